"""Text that people type: what can be shown on a screen and searched, as one form of Unicode."""

from __future__ import annotations

import unicodedata

from rehab_app.errors import Refused

LONGEST_TEXT = 4000
_JOINERS = "\u200c\u200d"  # Persian and the scripts of India write with them
_NEVER = ("Cc", "Cf", "Cs", "Co", "Cn")


def one_line(thing: str, text: str, longest: int) -> str:
    """A name or a short remark: trimmed, in composed form, one space between words.

    Args:
        thing: What it is, for the sentence.
        text: As it was typed.
        longest: Characters that it may have.

    Raises:
        Refused: It is too long or holds characters that no screen shows.
    """
    return _checked(thing, text.strip(), longest, "")


def many_lines(thing: str, text: str, longest: int = LONGEST_TEXT) -> str:
    """A note of several lines; line ends become a single character, as browsers send two.

    Raises:
        Refused: It is too long or holds characters that no screen shows.
    """
    return _checked(thing, text.replace("\r\n", "\n").replace("\r", "\n").strip(), longest, "\n\t")


def needed(thing: str, text: str) -> str:
    """A text that may not be empty.

    Raises:
        Refused: It is.
    """
    if not text:
        raise Refused(thing, "empty", "filled in", "fill it in")
    return text


def _checked(thing: str, text: str, longest: int, also: str) -> str:
    composed = unicodedata.normalize("NFC", text)
    if len(composed) > longest:
        raise Refused(
            thing, f"{len(composed)} characters long", f"at most {longest} characters", "shorten it"
        )
    for one in composed:
        if unicodedata.category(one) in _NEVER and one not in also and one not in _JOINERS:
            value = f"typed with a hidden character (U+{ord(one):04X})"
            raise Refused(thing, value, "written in characters that show", "type it instead of pasting it")
    return composed
