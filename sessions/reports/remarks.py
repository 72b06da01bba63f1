"""What the measurement says of a number, in the reader's language: remarks are put together from parts."""

from __future__ import annotations

import re
from functools import lru_cache

from sessions.reports.language import _, decimal, marked
from sessions.reports.wording import MODES

SAID = (
    "estimated from other joints, not measured",
    "the take need not show full effort",
    "reliability is known for reaching arms, not for fingers",
    "measured in %(share)s of the frames",
    "a joint of the digit was estimated in %(share)s of the frames",
    "at least, %(met)s",
    "at most, %(met)s",
    "device limit",
    "today's limit",
    "one-sided interval, not below %(end)s",
    "one-sided interval, not above %(end)s",
    "interval cut where the number itself ends",
    "interval scaled to the errors measured against the virtual camera's truth",
    "no interval: the error is not stated",
    "no interval: it hangs on a threshold of the speed",
    "not separable from recoil and spasm: no passive curve of this day",
    "not separable: in passive mode what comes back is recoil or friction",
    "not separable: no passive curve of %(joint)s",
    "mean; it varied from %(least)s to %(most)s Nm/rad",
    "crease of the palm placed 12 mm palmar and 8 mm proximal of the knuckle",
    "from landmarks within %(far)s mm, not from touch",
    "above 6 a weak measure of opposition",
    "%(grade)s (ASSH: 100 %% excellent, over 75 good, over 50 fair, else poor)",
    "excellent",
    "good",
    "fair",
    "poor",
    "no phases were recorded",
    "the file does not say how many repetitions were prescribed",
    "no work was done",
    "no joint moved by 3 degrees",
    "the robot's torque stayed below its floor of 0.01 Nm",
    "the stiffness at which it was obtained is not in the file",
    "no repetition",
    "MCP, PIP and DIP were never measured together",
    "never measured for 0.3 s without a gap",
    "thumb and fingers were never measured together",
    "a joint of the finger was not measured in the fist or in the opening",
    "nothing moved",
    "no gap-free stroke",
    "no gap-free stroke of 5 mm or more, clear of the noise",
    "the interval knows nothing of the measurement's noise, which is not stated",
    "no gap-free path",
    "the path returns to where it began",
    "the number that it is compared with is 0",
    "the file does not hold the hand's bones",
    "the joint did not move",
    "fewer than three repetitions",
    "fewer than two repetitions",
    "fewer than two strokes",
    "fewer than two frames were recorded",
    "the first stroke has no amplitude",
    "no interaction torque was measured",
    "the profile has a gap",
    "the speed does not change",
    "no sample was measured while the reference was played",
    "no repetition was begun by the patient",
    "the robot does not drive it",
    "the robot does not drive it while the movement closes it",
    "the robot does not drive it while the movement opens it",
    "the robot moved the hand",
    "the robot measured no torque within a repetition",
    "the measurement's noise or strokes are unknown",
    "the file holds no robot command",
    "the main movement was never seen for 0.3 s without a gap",
    "nothing was measured",
    "no frame was recorded",
    "no frame states a residual",
    "longer than 60 s",
    "it was not measured",
    "stiffness %(span)s Nm/rad (%(multiple)s times the thesis gains)",
    "stiffness %(span)s Nm/rad",
    "stiffness %(multiple)s times the thesis gains",
    "%(modes)s mode",
    "%(low)s to %(high)s",
    "%(one)s and %(other)s",
    "repetition %(n)s of %(count)s",
    "the whole take",
    "zero-phase Butterworth low-pass, order 4, %(cut)s Hz",
    "%(rate)s samples/s",
    "norm MCP 90, PIP 100, DIP 80, thumb MP 55, IP 80 deg",
    "unknown",
    "encoder",
    "virtual-camera",
    "the file holds no robot state",
    "the device does not measure interaction torque",
    "not separable: the passive curve of this day does not reach as far",
    "not separable: the passive run is of another hand",
    "not separable: the passive run is of another day",
    "not separable: the passive run is of another device",
    "n = %(n)s, this clinic, age %(ages)s",
    "better",
    "worse",
    "same",
    "matters",
    "may matter",
    "too small to matter",
    "not known",
    "matters (published: %(published)s)",
    "may matter (published: %(published)s)",
    "too small to matter (published: %(published)s)",
    "not known (published: %(published)s)",
    "no important difference is published",
    "measured once",
    "its file is not the one that was sealed",
    "its file is of %(whose)s, not of %(patient)s",
    "of the left hand",
    "of the right hand",
    "encoders of %(device)s",
    "not recorded",
)
"""What the measurement and the records say, whole or as a part that others stand beside."""
_CLEARER = {
    "no interval: %(n)s of at least %(least)s": marked(
        "no interval: %(n)s movements were seen whole, at least %(least)s are needed"
    ),
    **MODES,
}
"""What the measurement says, and how a reader is told."""
_MODE = "passive|assistive|transparent|resistive|unknown"
_HOLDS = {"modes": r"[\w ]+", "one": _MODE, "other": f"{_MODE}|.+ and .+"}
_NUMBER = r"-?[\d.]+"
_NUMERIC = frozenset("low high n least most count cut rate".split())


def remark(text: str) -> str:
    """A remark of the measurement in the reader's language; what is not known stays as it is."""
    whole = _known(text)
    if whole is not None:
        return whole
    for separator in ("; ", ", "):
        parts = text.split(separator)
        if len(parts) > 1:
            return separator.join(remark(part) for part in parts)
    return decimal(_tidy(_(text)))


def _known(text: str) -> str | None:
    """The translation of a text that one template makes, None where none does."""
    for pattern, shown in _patterns():
        found = pattern.fullmatch(text)
        if found:
            return _(shown, **{name: remark(value) for name, value in found.groupdict().items()})
    return None


def _tidy(text: str) -> str:
    """Units as the other numbers of a report have them."""
    return re.sub(r"(?<=\d)%", " %", re.sub(r"(?<=\d) deg\b", "°", text))


@lru_cache(maxsize=1)
def _patterns() -> tuple[tuple[re.Pattern[str], str], ...]:
    """Each template as a pattern, those without placeholders first."""
    pairs = [*((text, text) for text in SAID), *_CLEARER.items()]
    return tuple((_pattern(text), shown) for text, shown in sorted(pairs, key=lambda one: "%(" in one[0]))


def _pattern(text: str) -> re.Pattern[str]:
    parts = re.split(r"%\((\w+)\)s", text)
    made = [
        re.escape(part.replace("%%", "%") if len(parts) > 1 else part)
        if place % 2 == 0
        else f"(?P<{part}>{_NUMBER if part in _NUMERIC else _HOLDS.get(part, '.+?')})"
        for place, part in enumerate(parts)
    ]
    return re.compile("".join(made))
