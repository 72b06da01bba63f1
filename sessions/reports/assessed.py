"""Guided assessments in the progress report: active and passive range, lag and deficit, and tone.

A range assessment is brought into the form of two past sessions, one in which the patient moved and one in
which the device did, so that the same rules judge its changes as those of any other number.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from sessions.metrics import Estimate, definition
from sessions.metrics.norms import lag, norm_of, share_of
from sessions.reports.language import _, decimal, marked
from sessions.reports.paper import Words
from sessions.reports.past import Kept, Past
from sessions.reports.wording import MISSING, joint_name

EXERCISE = "range assessment"
BY_JOINT = ("range_of_motion", "range_share", "extension_lag", "contracture")
NO_GRADE = marked("This is torque that a device measured, and no Modified Ashworth grade.")
AT_END = "flagged: at least, device limit"


@dataclass(frozen=True, slots=True)
class Ends:
    """Ends of one joint's range in one assessment, rad, flexion positive; NaN where not measured.

    Attributes:
        joint: Its name.
        active: Smallest and largest angle that the patient reached alone.
        passive: Smallest and largest angle that the device reached gently.
        at_device_end: Whether a passive end was the device's.
    """

    joint: str
    active: tuple[float, float]
    passive: tuple[float, float]
    at_device_end: bool


@dataclass(frozen=True, slots=True)
class Tone:
    """What stretching one joint showed in one assessment.

    Attributes:
        utc_ns: When.
        device: What measured it.
        joint: Its name.
        speeds_rad_s: Speeds that were reached.
        resistance_nm: Mean torque against each.
        per_speed_nms_rad: Rise of the torque with speed, NaN where speeds were too alike.
        interval_nms_rad: Its 95 % interval, None without one.
    """

    utc_ns: int
    device: str
    joint: str
    speeds_rad_s: tuple[float, ...]
    resistance_nm: tuple[float, ...]
    per_speed_nms_rad: float
    interval_nms_rad: tuple[float, float] | None


def ranges_as_pasts(
    session_id: str, utc_ns: int, side: str, device: str, ends: Sequence[Ends]
) -> tuple[Past, Past]:
    """One assessment as two pasts: what the patient reached alone, and what the device reached.

    Args:
        session_id: Catalogue id of the session that it was read from.
        utc_ns: When.
        side: Side of the hand.
        device: Device whose encoders measured it.
        ends: What was found, by joint.
    """
    source = f"encoders of {device}"
    alone, moved = list[Kept](), list[Kept]()
    for one in ends:
        status = AT_END if one.at_device_end else "ok"
        own = lag(_angle(one.active[0]), _angle(one.passive[0]))
        alone += [
            *_range(one.joint, one.active, source, "ok"),
            _kept("extension_lag", one.joint, own.extension_lag, source, "ok"),
        ]
        moved += [
            *_range(one.joint, one.passive, source, status),
            _kept("contracture", one.joint, own.contracture, source, status.replace("least", "most")),
        ]

    def past(mode: str, numbers: list[Kept]) -> Past:
        return Past(session_id, "", "", utc_ns, side, EXERCISE, (mode,), numbers=tuple(numbers))

    return past("transparent", alone), past("passive", moved)


def tone_words(tones: Sequence[Tone]) -> Words | None:
    """Tone at each speed in the first, the last but one and the latest assessment; None without any.

    Args:
        tones: All joints of all assessments, oldest first.
    """
    if not tones:
        return None
    rows: list[tuple[str, ...]] = []
    for joint in dict.fromkeys(one.joint for one in tones):
        of_joint = [one for one in tones if one.joint == joint]
        alike = [one for one in of_joint if one.device == of_joint[-1].device]
        shown = (alike[0] if len(alike) > 1 else None, alike[-2] if len(alike) > 2 else None, alike[-1])
        rows.append((joint_name(joint), *(_tone(one) for one in shown), _judged(alike)))
    return Words(
        (_("Resistance to stretching"), _("Baseline"), _("Last"), _("Now"), _("Change")), tuple(rows)
    )


def _tone(one: Tone | None) -> str:
    if one is None:
        return MISSING
    parts = [
        _(
            "%(torque)s Nm at %(speed)s °/s",
            torque=decimal(f"{torque:.3f}"),
            speed=f"{math.degrees(speed):.0f}",
        )
        for speed, torque in zip(one.speeds_rad_s, one.resistance_nm, strict=True)
        if math.isfinite(speed) and math.isfinite(torque)
    ]
    return ", ".join(parts) or MISSING


def _judged(alike: Sequence[Tone]) -> str:
    """What may be said of the rise with speed: its repeatability is not known, so never that it is real."""
    first, now = alike[0], alike[-1]
    if len(alike) < 2:
        return _("measured once")
    if first.interval_nms_rad is None or now.interval_nms_rad is None:
        return _("not measurable: speeds too alike")
    apart = abs(now.per_speed_nms_rad - first.per_speed_nms_rad)
    both = math.hypot(*((high - low) / 2.0 for low, high in (first.interval_nms_rad, now.interval_nms_rad)))
    rise = _(
        "%(before)s, now %(now)s Nm s/rad",
        before=decimal(f"{first.per_speed_nms_rad:.3f}"),
        now=decimal(f"{now.per_speed_nms_rad:.3f}"),
    )
    within = _("beyond both intervals") if apart > both else _("within both intervals")
    return _(
        "not measurable: repeatability unknown; rise with speed %(rise)s, %(within)s",
        rise=rise,
        within=within,
    )


def _range(joint: str, ends: tuple[float, float], source: str, status: str) -> list[Kept]:
    width = ends[1] - ends[0]
    extent = Estimate(width) if math.isfinite(width) else Estimate.missing("not measured")
    found = [_kept("range_of_motion", joint, extent, source, status)]
    norm = norm_of(joint)
    if norm is not None:
        found.append(_kept("range_share", joint, share_of(extent, Estimate(norm)), source, status))
    return found


def _angle(value: float) -> Estimate:
    return Estimate(value) if math.isfinite(value) else Estimate.missing("not measured")


def _kept(name: str, joint: str, found: Estimate, source: str, status: str) -> Kept:
    known = math.isfinite(found.value)
    said = status if known else f"not measurable: {found.reason}"
    low, high = found.interval or (None, None)
    value = found.value if known else None
    return Kept(name, joint, value, low, high, said, definition(name).version, source)
