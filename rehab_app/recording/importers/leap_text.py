"""The text of a Leap Motion playback file: JSON as it stands, or pressed by lz-string into base64 letters.

lz-string is LZ78 with codes that grow by a bit whenever the table of phrases fills; bits of a code come
lowest first. What it unpacks to is bounded, for a small file can state a huge one.
"""

from __future__ import annotations

import base64
import binascii
import json
from pathlib import Path
from typing import Any

from sessions.errors import Refused

PRESSED = ".lz"
"""Suffix of the pressed form."""
MOST_PRESSED_BYTES = 16 << 20
MOST_LETTERS = 96 << 20

_BYTE, _WORD, _END = 0, 1, 2  # codes that bring a new letter of 8 or 16 bits, or the end


class _CutError(ValueError):
    """The pressed text ends, or refers to what it never held."""


class _HugeError(ValueError):
    """The text grows beyond its bound."""


def unpress(text: str, most: int) -> str:
    """What lz-string's ``compressToBase64`` was given.

    Args:
        text: The base64 letters.
        most: Most letters that may come of it.

    Raises:
        ValueError: The text is not base64, is cut, or holds more than ``most`` letters.
    """
    bare = "".join(text.split()).rstrip("=")
    held = base64.b64decode(bare + "A" * (-len(bare) % 4), validate=True)
    if not held:
        raise _CutError
    bits = format(int.from_bytes(b"\x01" + held, "big"), "b")[1:]
    return _phrases(bits, most)


def _phrases(bits: str, most: int) -> str:
    """Follow the codes, phrase by phrase."""
    table: list[str] = ["", "", ""]
    found: list[str] = []
    letters, before, at, width, room = 0, "", 0, 2, 1
    while True:
        code, at = _code(bits, at, width)
        if code == _END:
            return "".join(found)
        if code < _END:
            letter, at = _code(bits, at, 8 if code == _BYTE else 16)
            table.append(chr(letter))
            code = len(table) - 1
            width, room = _wider(width, room)
        phrase = _phrase(table, code, before)
        found.append(phrase)
        letters += len(phrase)
        if letters > most:
            raise _HugeError
        if before:
            table.append(before + phrase[0])
            width, room = _wider(width, room)
        before = phrase


def _code(bits: str, at: int, width: int) -> tuple[int, int]:
    """The code at a place, lowest bit first, and the place after it."""
    if at + width > len(bits):
        raise _CutError
    return int(bits[at : at + width][::-1], 2), at + width


def _wider(width: int, room: int) -> tuple[int, int]:
    """Width of the codes after one more phrase, and how many phrases fit until the next bit."""
    return (width, room - 1) if room > 1 else (width + 1, 1 << width)


def _phrase(table: list[str], code: int, before: str) -> str:
    if code < len(table):
        return table[code]
    if code > len(table) or not before:
        raise _CutError
    return before + before[0]


def read_document(path: Path) -> Any:
    """The JSON document of a playback file.

    Raises:
        Refused: The file is no text, not pressed by lz-string, too large, cut, or no JSON of numbers.
    """
    where = f"recording {path.name}"
    text = _text(path, where)
    try:
        return json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise Refused(
            where, "no whole JSON of finite numbers", "a Leap Motion playback file", "record it again"
        ) from error


def _text(path: Path, where: str) -> str:
    pressed = path.suffix.lower() == PRESSED
    most = MOST_PRESSED_BYTES if pressed else MOST_LETTERS
    if path.stat().st_size > most:
        raise Refused(where, f"{path.stat().st_size} bytes long", f"at most {most} bytes", "cut it shorter")
    try:
        text = path.read_text("utf-8-sig")
        return unpress(text, MOST_LETTERS) if pressed else text
    except _CutError as error:
        raise Refused(where, "cut or damaged", "a whole file of lz-string", "copy it again") from error
    except _HugeError as error:
        raise Refused(
            where, f"longer than {MOST_LETTERS} letters unpacked", "at most that", "cut it shorter"
        ) from error
    except (UnicodeError, binascii.Error, ValueError) as error:
        raise Refused(
            where, "not pressed by lz-string" if pressed else "no text", "a Leap Motion playback file",
            "export it again",
        ) from error  # fmt: skip


def _no_number(constant: str) -> float:
    raise ValueError(constant)
