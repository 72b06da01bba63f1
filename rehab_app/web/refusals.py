"""A refusal as a sentence of a page: in the language of the request where every part of it is known."""

from __future__ import annotations

import re

from rehab_app.errors import Refused, RobotRefused
from rehab_app.web.language import SOURCE, _, marked, spoken

_WORDS = frozenset(
    (
        # what is refused
        marked("birth date"),
        marked("hand length"),
        marked("given name"),
        marked("family name"),
        marked("new password"),
        marked("password"),
        marked("user name"),
        marked("name"),
        marked("sign-in"),
        marked("stop"),
        marked("movement"),
        marked("live desk"),
        marked("pain"),
        marked("event date"),
        marked("note"),
        marked("remark"),
        marked("reason"),
        marked("goal"),
        marked("what happened"),
        marked("what was done"),
        marked("sessions per week"),
        marked("plan"),
        marked("speed"),
        marked("countdown"),
        marked("idle lock"),
        marked("date of the measurement"),
        # how it is
        marked("empty"),
        marked("wrong"),
        marked("latched"),
        marked("pressed"),
        marked("still braking and sealing"),
        marked("held"),
        marked("the old one"),
        marked("as it was"),
        # how it must be
        marked("filled in"),
        marked("today or before"),
        marked("after the patient's birth"),
        marked("the name and password of an account"),
        marked("another one"),
        marked("cleared"),
        marked("at rest"),
        marked("not held"),
        marked("free"),
        marked("changed"),
        marked("0 (none) to 10 (worst)"),
        marked("cleared only by someone who looked at the patient"),
        marked("unchanged since you opened it"),
        marked("a date as YYYY-MM-DD"),
        # what to do
        marked("correct it"),
        marked("fill it in"),
        marked("correct the year"),
        marked("correct one of the dates"),
        marked("check both and try again"),
        marked("choose another"),
        marked("choose within it"),
        marked("shorten it"),
        marked("ask again"),
        marked("confirm that you did"),
        marked("compare and save again"),
        marked("choose a speed within it"),
        marked("choose a shorter countdown"),
        marked("change the prescription"),
        marked("look at the patient and clear the stop"),
        marked("look at the patient and press Resume first"),
        marked("wait until it is done, or stop it"),
        marked("change something, or leave the page"),
        marked("measure wrist crease to middle fingertip"),
    )
)
"""Parts of the refusals that people meet most; a refusal with any other part stays English as a whole."""
_RANGE = re.compile(r"([\d.,-]+) to ([\d.,-]+)( [^ ]{1,8})?")
_NUMBER = re.compile(r"[-\d.,:]+( [^ ]{1,8})?")
_LENGTH = re.compile(r"(\d+) characters long")
_MOST = re.compile(r"at most (\d+) characters")


def sentence_of(refusal: Refused | RobotRefused) -> str:
    """A refusal as a sentence of its own: capital letter, full stop."""
    text = str(refusal) if spoken() == SOURCE else _told(refusal) or str(refusal)
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def _told(refusal: Refused | RobotRefused) -> str:
    """The refusal in the language of the request, empty where a part of it is not known."""
    parts = [_part(text) for text in (refusal.thing, refusal.value, refusal.bound, refusal.remedy)]
    if not all(parts):
        return ""
    thing, value, bound, remedy = parts
    said = {"thing": thing, "value": value, "bound": bound, "remedy": remedy}
    return _("%(thing)s is %(value)s, but must be %(bound)s: %(remedy)s.") % said


def _part(text: str) -> str:
    """One part, translated; a number or a quoted word is a part as it is."""
    if text in _WORDS:
        return _(text)
    span, length, most = _RANGE.fullmatch(text), _LENGTH.fullmatch(text), _MOST.fullmatch(text)
    if span is not None:
        ends = {"low": span[1], "high": span[2]}
        return _("%(low)s to %(high)s") % ends + (span[3] or "")
    if length is not None:
        return _("%(n)s characters long") % {"n": length[1]}
    if most is not None:
        return _("at most %(n)s characters") % {"n": most[1]}
    quoted = text[:1] == text[-1:] == "'" or _NUMBER.fullmatch(text)
    return text if quoted else ""
