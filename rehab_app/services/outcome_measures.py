"""Outcome measures that a clinic enters by hand: range, unit, side, which way is better, what matters.

Only published minimal clinically important differences stand here, and only those that the clinical notes of
the project cite: ARAT 6 (chronic) to 17 (acute, dominant hand), Box and Block 6, grip 5.0 to 6.2 kg,
QuickDASH 14, pain 2 to 2.5. Where none is known for the hand, none is invented.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

from rehab_app.errors import Refused

Better: TypeAlias = Literal["higher", "lower"]
Choices: TypeAlias = tuple[tuple[str, float], ...]

_DEGREE = math.pi / 180.0
_JOINTS = ("wrist", "thumb", "fingers", "MCP", "PIP", "DIP")
_SITES = ("thumb", "index", "middle", "ring", "little", "palm", "back of the hand")
_PINCHES = ("tip", "key", "three-jaw")


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """One outcome measure.

    Attributes:
        key: How the catalogue and the command line name it.
        words: How a person reads it.
        low: Least value, in ``unit``.
        high: Greatest value.
        unit: Unit in which values are kept; "1" for a score.
        shown: Unit as a person reads it, empty for a score.
        per_shown: How much of ``unit`` one shown unit is.
        whole: Whether shown values are whole numbers.
        better: Which way is better.
        sided: Whether it belongs to one hand.
        places: Joint, digit or kind of grip, one of which must be named; empty where there is none.
        mcid: Least and greatest published change that matters, in ``unit``, both positive; None for unknown.
        mcid_words: For whom, if that differs.
        choices: Words and values where only some values exist.
        hint: How it is taken, in a few words.
    """

    key: str
    words: str
    low: float
    high: float
    unit: str = "1"
    shown: str = ""
    per_shown: float = 1.0
    whole: bool = False
    better: Better = "higher"
    sided: bool = True
    places: tuple[str, ...] = ()
    mcid: tuple[float, float] | None = None
    mcid_words: str = ""
    choices: Choices = ()
    hint: str = ""

    def text(self, value: float) -> str:
        """A value in ``unit`` as a person reads it, without the unit."""
        for words, known in self.choices:
            if math.isclose(known, value):
                return words
        return f"{round(value / self.per_shown, 2):g}"

    @property
    def range_text(self) -> str:
        """What may be entered, as a person reads it."""
        if self.choices:
            return "one of " + ", ".join(words for words, _ in self.choices)
        kind = ", whole" if self.whole else ""
        return f"{self.text(self.low)} to {self.text(self.high)}{' ' * bool(self.shown)}{self.shown}{kind}"

    def read(self, typed: str) -> float:
        """What somebody typed, in ``unit``; decimal comma or point.

        Raises:
            Refused: It is no value of this measure.
        """
        text = typed.strip()
        for words, value in self.choices:
            if text == words:
                return value
        try:
            value = math.nan if self.choices else float(text.replace(",", ".")) * self.per_shown
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise Refused(self.words, repr(text[:40]) if text else "empty", self.range_text, "enter it again")
        return self.check(value)

    def check(self, value: float) -> float:
        """Let a value in ``unit`` pass.

        Raises:
            Refused: It is out of range, or between the values that exist.
        """
        slack = 1e-9 * max(1.0, self.high)
        fits = math.isfinite(value) and self.low - slack <= value <= self.high + slack
        shown = value / self.per_shown if fits else 0.0
        if self.choices:
            fits = any(math.isclose(known, value) for _, known in self.choices)
        if not fits or (self.whole and not math.isclose(shown, round(shown), abs_tol=1e-9)):
            raise Refused(
                self.words, f"{self.text(value)} {self.shown}".strip(), self.range_text, "correct it"
            )
        return value


_MAS: Choices = (("0", 0.0), ("1", 1.0), ("1+", 1.5), ("2", 2.0), ("3", 3.0), ("4", 4.0))


def _pain(when: str) -> Measure:
    return Measure(
        key=f"pain-{when}",
        words=f"Pain {when}",
        low=0.0,
        high=10.0,
        whole=True,
        better="lower",
        sided=False,
        mcid=(2.0, 2.5),
        hint="0 none, 10 worst",
    )


MEASURES: tuple[Measure, ...] = (
    Measure(key="fma-hand", words="Fugl-Meyer, hand", low=0.0, high=14.0, whole=True, hint="of 14"),
    Measure(
        key="arat",
        words="ARAT",
        low=0.0,
        high=57.0,
        whole=True,
        mcid=(6.0, 17.0),
        mcid_words="6 chronic, 12 to 17 acute",
        hint="of 57",
    ),
    Measure(
        key="box-and-block",
        words="Box and Block",
        low=0.0,
        high=150.0,
        shown="blocks",
        whole=True,
        mcid=(6.0, 6.0),
        hint="in 60 s; enter each hand",
    ),
    Measure(
        key="nine-hole-peg",
        words="Nine-hole peg",
        low=5.0,
        high=600.0,
        unit="s",
        shown="s",
        better="lower",
        hint="time to place and remove",
    ),
    Measure(
        key="grip",
        words="Grip strength",
        low=0.0,
        high=120.0,
        unit="kg",
        shown="kg",
        mcid=(5.0, 6.2),
        hint="mean of three",
    ),
    Measure(
        key="pinch",
        words="Pinch strength",
        low=0.0,
        high=30.0,
        unit="kg",
        shown="kg",
        places=_PINCHES,
        hint="mean of three",
    ),
    Measure(
        key="mas",
        words="Modified Ashworth",
        low=0.0,
        high=4.0,
        better="lower",
        places=_JOINTS,
        choices=_MAS,
        hint="flexors, by hand; never from the robot",
    ),
    Measure(
        key="tardieu-r1",
        words="Tardieu R1 (fast, catch)",
        low=-90.0 * _DEGREE,
        high=120.0 * _DEGREE,
        unit="rad",
        shown="degrees",
        per_shown=_DEGREE,
        places=_JOINTS,
        hint="angle of extension at which the catch comes",
    ),
    Measure(
        key="tardieu-r2",
        words="Tardieu R2 (slow, end)",
        low=-90.0 * _DEGREE,
        high=120.0 * _DEGREE,
        unit="rad",
        shown="degrees",
        per_shown=_DEGREE,
        places=_JOINTS,
        hint="angle of extension at the passive end",
    ),
    Measure(
        key="monofilament",
        words="Monofilament",
        low=1.65,
        high=6.65,
        better="lower",
        places=_SITES,
        hint="number of the finest one felt",
    ),
    Measure(key="gas-t", words="Goal attainment T", low=0.0, high=100.0, sided=False, hint="50 as expected"),
    Measure(key="copm-performance", words="COPM performance", low=1.0, high=10.0, sided=False),
    Measure(key="copm-satisfaction", words="COPM satisfaction", low=1.0, high=10.0, sided=False),
    Measure(
        key="quickdash",
        words="QuickDASH",
        low=0.0,
        high=100.0,
        better="lower",
        sided=False,
        mcid=(14.0, 14.0),
        hint="100 is the most disabled",
    ),
    _pain("before"),
    _pain("during"),
    _pain("after"),
)


def measure(key: str) -> Measure:
    """The measure of that key.

    Raises:
        Refused: There is none.
    """
    for one in MEASURES:
        if one.key == key:
            return one
    known = ", ".join(one.key for one in MEASURES)
    raise Refused("outcome measure", repr(key[:40]), f"one of {known}", "choose one of these")
