"""What the assessment protocols found, as values that the catalogue keeps. Angles come from encoders."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from robot_iface.motion.limits import SweepResult
from robot_iface.runtime.sweep_tone_reading import ToneResult
from robot_iface.types import Float64
from sessions.metrics import Summary

Protocol: TypeAlias = Literal["range", "tone", "tracking"]
PROTOCOLS: tuple[Protocol, ...] = ("range", "tone", "tracking")
_TRACKED = ("fingertip_rmse", "timing_delay", "timing_warp", "shape_error", "offset_error")


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRange:
    """Active and passive range of one joint; None where it was not measured. rad, flexion positive.

    Attributes:
        joint: Its name.
        active_min_rad: Farthest extension that the patient reached alone.
        active_max_rad: Farthest flexion likewise.
        passive_min_rad: Farthest extension that the device reached gently.
        passive_max_rad: Farthest flexion likewise.
        extension_lag_rad: What is missing to passive extension when the patient extends alone: weakness.
        extension_deficit_rad: What is missing to straight passively: shortness.
        flexion_lag_rad: What is missing to passive flexion when the patient flexes alone.
        min_at_device_end: Whether passive extension ended at the device: the patient's own is at least that.
        max_at_device_end: Whether passive flexion did.
    """

    joint: str
    active_min_rad: float | None
    active_max_rad: float | None
    passive_min_rad: float | None
    passive_max_rad: float | None
    extension_lag_rad: float | None
    extension_deficit_rad: float | None
    flexion_lag_rad: float | None
    min_at_device_end: bool
    max_at_device_end: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class JointTone:
    """What stretching one joint showed. This is no Modified Ashworth grade.

    Attributes:
        joint: Its name.
        reached_rad_s: Speed of each stretch, None where the joint was not moved enough.
        resistance_nm: Mean torque against it over the common middle of the way.
        catch_rad: Angle of the catch, None where there was none.
        per_speed_nms_rad: How much resistance rises with speed; None where speeds were too alike.
        interval_nms_rad: Its 95 % interval.
    """

    joint: str
    reached_rad_s: tuple[float | None, ...]
    resistance_nm: tuple[float | None, ...]
    catch_rad: tuple[float | None, ...]
    per_speed_nms_rad: float | None
    interval_nms_rad: tuple[float, float] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracked:
    """One number of a tracking test.

    Attributes:
        name: Name of the metric.
        subject: Digit or whole.
        value: In ``unit``; None where it could not be had.
        unit: SI unit.
        interval: 95 % interval, None where no honest one exists.
        status: As of the metric.
    """

    name: str
    subject: str
    value: float | None
    unit: str
    interval: tuple[float, float] | None
    status: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolResult:
    """The result of one protocol.

    Attributes:
        protocol: Which.
        session: Catalogue id of the sealed session that it was read from.
        device: Device whose encoders measured it.
        side: Side of the hand.
        wrist_rad: Extension at which the wrist was held.
        arm_posture: How arm and shoulder were held, in words; tone depends on it.
        asked_rad_s: Of tone: the speeds asked for; the limits of the hand may have made them slower.
        notes: What must be said of it, one sentence each.
        ranges: Of range.
        tones: Of tone.
        tracked: Of tracking.
    """

    protocol: Protocol
    session: str
    device: str
    side: str
    wrist_rad: float
    arm_posture: str = ""
    asked_rad_s: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()
    ranges: tuple[JointRange, ...] = ()
    tones: tuple[JointTone, ...] = ()
    tracked: tuple[Tracked, ...] = ()


def ranges_of(result: SweepResult) -> tuple[JointRange, ...]:
    """Active and passive ends over all postures of a range sweep."""
    return tuple(_range(result, joint) for joint in range(len(result.joint_names)))


def tones_of(result: ToneResult) -> tuple[JointTone, ...]:
    """Joints that were stretched."""
    moved = np.isfinite(result.reached_rad_s).any(axis=0)
    return tuple(_tone(result, joint) for joint in np.flatnonzero(moved).tolist())


def tone_notes(result: ToneResult) -> tuple[str, ...]:
    """What must be said of a tone test, one sentence each."""
    notes = ["This is no Modified Ashworth grade: a device measured it, no hand."]
    for asked in sorted(set(result.asked_rad_s.tolist())):
        rows = result.reached_rad_s[result.asked_rad_s == asked]
        reached = float(np.nanmedian(rows)) if np.isfinite(rows).any() else math.nan
        if not reached >= 0.85 * asked:
            slower = "not at all" if math.isnan(reached) else f"at {math.degrees(reached):.0f}"
            notes.append(
                f"{math.degrees(asked):.0f} degrees/s was asked for and made {slower}: limits or load."
            )
    if result.verdict:
        notes.append(f"The test was {result.verdict}.")
    return tuple(notes)


def tracked_of(summary: Summary) -> tuple[Tracked, ...]:
    """What a tracking test says of timing, shape and offset."""
    return tuple(
        Tracked(
            name=one.name,
            subject=one.subject,
            value=one.value if one.measurable else None,
            unit=one.unit,
            interval=one.interval,
            status=one.status,
        )
        for one in summary.metrics
        if one.name in _TRACKED
    )


def _range(result: SweepResult, joint: int) -> JointRange:
    active, passive = result.active_rad[:, joint], result.passive_rad[:, joint]
    low_active, high_active = _ends(active)
    low, high = _ends(passive)
    ends = result.device_end[:, joint]
    return JointRange(
        joint=result.joint_names[joint],
        active_min_rad=low_active,
        active_max_rad=high_active,
        passive_min_rad=low,
        passive_max_rad=high,
        extension_lag_rad=_beyond(low_active, low),
        extension_deficit_rad=None if low is None else max(low, 0.0),
        flexion_lag_rad=_beyond(high, high_active),
        min_at_device_end=low is not None and bool(ends[int(np.nanargmin(passive))]),
        max_at_device_end=high is not None and bool(ends[int(np.nanargmax(passive))]),
    )


def _tone(result: ToneResult, joint: int) -> JointTone:
    slope = _known(float(result.per_speed_nms_rad[joint]))
    interval = (float(result.per_speed_low[joint]), float(result.per_speed_high[joint]))
    return JointTone(
        joint=result.joint_names[joint],
        reached_rad_s=_column(result.reached_rad_s, joint),
        resistance_nm=_column(result.resistance_nm, joint),
        catch_rad=_column(result.catch_rad, joint),
        per_speed_nms_rad=slope,
        interval_nms_rad=None if slope is None else interval,
    )


def _column(values: Float64, joint: int) -> tuple[float | None, ...]:
    return tuple(_known(value) for value in values[:, joint].tolist())


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _ends(values: Float64) -> tuple[float | None, float | None]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (None, None)


def _beyond(more: float | None, less: float | None) -> float | None:
    return None if more is None or less is None else max(more - less, 0.0)
