"""What is written in the journal of a patient: notes, pain, adverse events, check-ins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from rehab_app.errors import Refused
from rehab_app.services.plain_text import many_lines, needed, one_line

WHENS = ("", "before", "during", "after", "rest")
"""When a pain was felt, seen from the exercise."""
SEVERITIES = ("mild", "moderate", "severe")
SKIN = ("", "intact", "red", "broken")
SWELLING = ("", "none", "some", "much")
HIGHEST_PAIN = 10
_PLACE = 80
_REMARK = 500


@dataclass(frozen=True, slots=True)
class Note:
    """Free text.

    Raises:
        Refused: It is empty, too long or cannot be shown.
    """

    text: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", needed("note", many_lines("note", self.text)))


@dataclass(frozen=True, slots=True)
class PainReport:
    """A pain.

    Attributes:
        score: 0 (none) to 10 (worst thinkable); None where only "it hurts" was said, by one tap.
        place: Where.
        when: One of WHENS.
        remark: Anything else.

    Raises:
        Refused: The score is none, or a text is too long.
    """

    score: int | None
    place: str = ""
    when: str = ""
    remark: str = ""

    def __post_init__(self) -> None:
        check_pain(self.score)
        _one_of("when the pain was felt", self.when, WHENS)
        object.__setattr__(self, "place", one_line("place of the pain", self.place, _PLACE))
        object.__setattr__(self, "remark", many_lines("remark on the pain", self.remark, _REMARK))


@dataclass(frozen=True, slots=True)
class AdverseEvent:
    """Something that went wrong with a patient.

    Attributes:
        severity: One of SEVERITIES.
        happened: What happened.
        done: What was done about it.

    Raises:
        Refused: A part is missing or too long.
    """

    severity: str
    happened: str
    done: str

    def __post_init__(self) -> None:
        _one_of("severity", self.severity, SEVERITIES)
        happened, done = many_lines("what happened", self.happened), many_lines("what was done", self.done)
        object.__setattr__(self, "happened", needed("what happened", happened))
        object.__setattr__(self, "done", needed("what was done", done))


@dataclass(frozen=True, slots=True)
class CheckIn:
    """Answers before a session.

    Attributes:
        pain: 0 to 10, None where nobody asked.
        skin: One of SKIN.
        swelling: One of SWELLING.
        botulinum_date: ISO date of the last injection, empty for none or unknown.
        precautions: What is new about the hand.
        remark: Anything else.

    Raises:
        Refused: An answer is none of those, or too long.
    """

    pain: int | None = None
    skin: str = ""
    swelling: str = ""
    botulinum_date: str = ""
    precautions: str = ""
    remark: str = ""

    def __post_init__(self) -> None:
        check_pain(self.pain)
        _one_of("state of the skin", self.skin, SKIN)
        _one_of("swelling", self.swelling, SWELLING)
        object.__setattr__(self, "precautions", many_lines("precautions", self.precautions))
        object.__setattr__(self, "remark", many_lines("remark", self.remark, _REMARK))


Written: TypeAlias = Note | PainReport | AdverseEvent | CheckIn
KINDS: dict[str, type[Written]] = {
    "note": Note,
    "pain": PainReport,
    "adverse-event": AdverseEvent,
    "check-in": CheckIn,
}
"""The type behind each kind of entry."""


def check_pain(score: int | None) -> None:
    """Refuse what is no pain score.

    Raises:
        Refused: It is not 0 to 10.
    """
    if score is not None and not 0 <= score <= HIGHEST_PAIN:
        raise Refused("pain", f"{score}", f"0 (none) to {HIGHEST_PAIN} (worst)", "ask again")


def _one_of(thing: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        words = ", ".join(one for one in known if one)
        raise Refused(thing, repr(value[:40]) if value else "not chosen", f"one of {words}", "choose one")
