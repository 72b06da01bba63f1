"""Numbers and choices out of form fields; what is none is a sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rehab_app.errors import Refused
from rehab_app.web.visit import Visit


def decimal(text: str) -> float:
    """A number as people type it, with decimal comma or point; NaN where it is none."""
    try:
        return float(text.replace(",", ".").replace("\N{MINUS SIGN}", "-"))
    except ValueError:
        return math.nan


def number(visit: Visit, name: str, thing: str, bound: str, default: float | None = None) -> float:
    """A number that was typed.

    Args:
        visit: The request.
        name: Form field.
        thing: What it is, for the sentence.
        bound: What it should be, for the sentence.
        default: What an empty or absent field stands for, None where it must be typed.

    Raises:
        Refused: It is no finite number.
    """
    text = visit.asked(name)
    if not text and default is not None:
        return default
    value = decimal(text)
    if not math.isfinite(value):
        raise Refused(thing, repr(text[:40]), bound, "type one")
    return value


def whole(visit: Visit, name: str, thing: str, default: int | None = None) -> int:
    """A whole number that was typed, 0 to 999999.

    Raises:
        Refused: It is none.
    """
    text = visit.asked(name)
    if not text and default is not None:
        return default
    if not (text.isascii() and text.isdecimal() and len(text) <= 6):
        raise Refused(thing, repr(text[:40]), "a whole number", "type one")
    return int(text)


def not_overtaken(visit: Visit, thing: str, now: str, typed: str) -> None:
    """Refuse a form that somebody else's change has overtaken: its field "was" says from what it was made.

    Args:
        visit: The request.
        thing: What is changed, for the sentence.
        now: How it stands.
        typed: What is asked for; where it stands so already, nothing is overtaken.

    Raises:
        Refused: It was changed meanwhile.
    """
    if visit.form.get("was", now).strip() != now and typed != now:
        value = f"changed to {now!r} by somebody else meanwhile"
        raise Refused(thing, value, "as it was when you began", "decide, and send it again")


def choice(text: str, thing: str, known: Iterable[str]) -> str:
    """A choice from a list.

    Raises:
        Refused: It is not on the list.
    """
    names = tuple(known)
    if text not in names:
        raise Refused(thing, repr(text[:40]), "one of " + ", ".join(names), "choose it from the list")
    return text
