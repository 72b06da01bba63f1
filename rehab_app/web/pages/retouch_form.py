"""The form that retouches a take: what was typed, as a wish, and what was done, in words."""

from __future__ import annotations

import msgspec

from rehab_app.services.retouching import Slowing, Wish
from rehab_app.therapy.retouch import Operation, Scale, Slow, Smooth
from rehab_app.web.language import _, marked
from rehab_app.web.pages.asked import choice, number
from rehab_app.web.visit import Visit
from sessions.records import DIGITS

SMOOTHING: dict[str, tuple[str, float]] = {
    "light": (marked("Light"), 150.0),
    "medium": (marked("Medium"), 60.0),
    "strong": (marked("Strong"), 25.0),
}
"""How a page asks for smoothing: words, and the usual jerk of a joint afterwards in rad/s^3."""
DIGIT_CHOICES = ("all", *DIGITS)
_FIELDS = ("start", "end", "smooth", "slow", "digit", "scale", "reason")
_SECONDS = "a number of seconds"


def plain_form(visit: Visit) -> dict[str, str]:
    """What was typed, for the form that is shown again."""
    return {name: visit.asked(name) for name in _FIELDS}


def wish_of(visit: Visit) -> Wish:
    """What the form asks for; fields that are left as they were ask for nothing.

    Raises:
        Refused: A field is no number, or a choice is not on its list.
    """
    trim = None
    if visit.asked("start") or visit.asked("end"):
        trim = (
            number(visit, "start", "beginning of the part to keep", _SECONDS, 0.0),
            number(visit, "end", "end of the part to keep", _SECONDS),
        )
    smooth = visit.asked("smooth")
    slow = number(visit, "slow", "slowing factor", "1 to 10", 1.0)
    percent = number(visit, "scale", "scaling", "0 to 200 %", 100.0)
    digit = choice(visit.asked("digit") or "all", "digit", DIGIT_CHOICES)
    scaled = DIGITS if digit == "all" else (digit,)
    return Wish(
        trim_s=trim,
        smooth_rad_s3=SMOOTHING[choice(smooth, "smoothing", SMOOTHING)][1] if smooth else None,
        slow=() if slow == 1.0 else (Slowing(slow),),
        scale=() if percent == 100.0 else tuple((name, percent / 100.0) for name in scaled),
    )


def done_to(retouch: str) -> tuple[str, ...]:
    """What was done to a take, one sentence each; empty where nothing was."""
    if not retouch:
        return ()
    return tuple(_sentence(one) for one in msgspec.json.decode(retouch, type=tuple[Operation, ...]))


def _sentence(one: Operation) -> str:
    if isinstance(one, Smooth):
        return _("Smoothed to a usual jerk of %(jerk)g rad/s³.") % {"jerk": one.jerk_rad_s3}
    if isinstance(one, Scale):
        values = {"subject": _(one.subject.replace("_", " ")), "percent": 100.0 * one.factor}
        return _("Movement of %(subject)s scaled to %(percent).0f %%.") % values
    span = {"start": one.start_s, "end": one.end_s}
    if isinstance(one, Slow):
        return _("Slowed %(factor)g times from %(start).2f to %(end).2f s.") % {**span, "factor": one.factor}
    return _("Trimmed to %(start).2f to %(end).2f s.") % span
