"""Good, usable or redo: what the figures of a calibration mean for a person, in one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

Word: TypeAlias = Literal["good", "usable", "redo"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a calibration is worth.

    Attributes:
        word: "good", "usable" or "redo".
        why: One sentence.
    """

    word: Word
    why: str


@dataclass(frozen=True, slots=True)
class Bound:
    """What a figure must reach.

    Attributes:
        figure: Its key.
        name: Its name in a sentence.
        good: The least that is good.
        usable: The least that is usable.
        unit: What follows the number.
        scale: What the number is multiplied with where a person reads it.
        fewer_is_better: Whether small figures are the good ones.
        remedy: What to do about it, as an imperative.
    """

    figure: str
    name: str
    good: float
    usable: float
    unit: str
    scale: float
    fewer_is_better: bool
    remedy: str

    def word(self, value: float) -> Word:
        """What a value of this figure is worth; NaN is worth nothing."""
        sign = -1.0 if self.fewer_is_better else 1.0
        if sign * value >= sign * self.good:
            return "good"
        return "usable" if sign * value >= sign * self.usable else "redo"

    def sentence(self, value: float, word: Word) -> str:
        """Why a value is not better than ``word``."""
        limit = self.good if word == "usable" else self.usable
        side = "at most" if self.fewer_is_better else "at least"
        better = "good" if word == "usable" else "usable"
        shown, bound = f"{self.scale * value:.3g}{self.unit}", f"{self.scale * limit:.3g}{self.unit}"
        return f"{self.name} is {shown}, {better} is {side} {bound}: {self.remedy}"


_STILL = "hold board and camera still, keep the board flat, and check its size"
_SPREAD = "show the board also in the corners and near the edges of the image"
_TILT = "tilt the board by 20 to 45 degrees to all sides"
INTRINSICS_BOUNDS = (
    Bound("rms_share", "the error of the corners at 640 px width", 0.4, 1.0, " px", 1.0, True, _STILL),
    Bound("focal_share", "the uncertainty of the focal length", 0.0025, 0.01, " %", 100.0, True, _TILT),
    Bound("views", "the number of images used", 8, 4, "", 1.0, False, "take more images of the board"),
    Bound(
        "coverage", "the part of the image in which corners were seen", 0.5, 0.3, " %", 100.0, False, _SPREAD
    ),
    Bound("tilt_rad", "the steepest tilt of the board", 0.35, 0.17, "°", 57.29578, False, _TILT),
)
"""Of one camera; the error of the corners counts at an image width of 640 px."""
RIG_BOUNDS = (
    Bound("rms_share", "the error of the corners at 640 px width", 0.5, 1.2, " px", 1.0, True, _STILL),
    Bound("turn_std_rad", "the uncertainty of the cameras' turn", 0.002, 0.01, "°", 57.29578, True, _TILT),
    Bound("views", "the number of images that two cameras share", 6, 3, "", 1.0, False, "take more at once"),
)
"""Of several cameras beside each other."""
WORLD_BOUNDS = (
    Bound("rms_share", "the error of the corners at 640 px width", 0.6, 1.5, " px", 1.0, True, _STILL),
    Bound(
        "turn_std_rad",
        "the uncertainty of the camera's turn",
        0.005,
        0.02,
        "°",
        57.29578,
        True,
        "bring the board nearer",
    ),
)
"""Of a camera above a board that lies still."""


def judge(figures: Mapping[str, float], bounds: tuple[Bound, ...]) -> Verdict:
    """The verdict of the worst figure.

    Args:
        figures: Value of each bound's figure.
        bounds: What they must reach.
    """
    worst: Word = "good"
    why = "every figure is within its bound"
    for bound in bounds:
        word = bound.word(figures[bound.figure])
        if _RANK[word] > _RANK[worst]:
            worst, why = word, bound.sentence(figures[bound.figure], word)
    return Verdict(worst, why)


def worse(first: str, second: str) -> str:
    """The worse of two words; "unknown", of a file that does not say, lies between usable and good."""
    order = ("redo", "usable", "unknown", "good")
    return min(first, second, key=lambda word: order.index(word) if word in order else 2)


_RANK: dict[Word, int] = {"good": 0, "usable": 1, "redo": 2}
