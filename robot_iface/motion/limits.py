"""Today's limits from a measured range: what the passive postures enclose, less a margin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robot_iface.errors import Refused
from robot_iface.motion.polygon import area, convex_hull, inset, nearest, outside, within_box
from robot_iface.types import FINGERS, Float64, Hull, Limits, Side

INSET_RAD = float(np.deg2rad(5.0))
"""How far inside the measured range today's limits end (clinical.md, [P])."""
_NARROW_SHARE = 0.4  # of a range that is narrower than twice the margin, its middle fifth is left
_LEAST_WIDTH_RAD, _USUAL_WIDTH_RAD = (float(width) for width in np.deg2rad([2.0, 4.0]))
"""A range is left 4 degrees wide where it was at least twice that, else half of what it was, or 2 degrees."""
_LEAST_AREA_RAD2 = float(np.deg2rad(2.0)) ** 2


@dataclass(frozen=True, slots=True)
class SweepResult:
    """What a guided sweep measured. The source of every angle is the device's encoder.

    Attributes:
        joint_names: The J joints of the device.
        side: Side of the hand.
        postures: Names of the P postures.
        rest_rad: The relaxed hand before the sweep, (J,).
        active_rad: What the patient reached alone, (P, J); NaN where it was not asked for or broke off.
        passive_rad: What the device reached gently, (P, J); NaN where it broke off.
        load_nm: Interaction torque at the end of the passive part, (P, J); NaN likewise.
        patient_end: Whether load ended a joint's passive movement, (P, J): only then is it the patient's end.
        device_end: Whether it ended within 1 degree of the device's own range, (P, J): then the patient's
            range is at least that, never that.
        verdict: Empty, or one sentence why the measurement is not to be used.
    """

    joint_names: tuple[str, ...]
    side: Side
    postures: tuple[str, ...]
    rest_rad: Float64
    active_rad: Float64
    passive_rad: Float64
    load_nm: Float64
    patient_end: NDArray[np.bool_]
    device_end: NDArray[np.bool_]
    verdict: str = ""


def limits_of(
    result: SweepResult, base: Limits, *, measured_utc_ns: int, expires_utc_ns: int, wrist_rad: float
) -> Limits:
    """Limits by what was measured on the patient today, never wider than the limits that it is based on.

    Each joint's box ends 5 degrees inside the passive postures. MCP flexion and PIP of a finger share the
    convex hull of theirs less 5 degrees, because tightness couples them. The posture at rest, which carries
    no load, always belongs to both. A joint of which 5 degrees at each end would leave nothing keeps the
    middle of its range.

    Args:
        result: The measurement.
        base: Shipped limits of the same joints within the device's range; hyperextension is excluded or
            allowed there.
        measured_utc_ns: When it was measured.
        expires_utc_ns: Local midnight, from the caller.
        wrist_rad: Wrist extension at which it was measured.

    Raises:
        Refused: The sweep is not to be used, measured nothing, is for other joints or has expired already.
    """
    _check(result, base, measured_utc_ns, expires_utc_ns)
    rows = np.isfinite(result.passive_rad).all(axis=1)
    passive = np.clip(result.passive_rad[rows], base.q_min_rad, base.q_max_rad)
    rest = np.clip(result.rest_rad, base.q_min_rad, base.q_max_rad)
    low, high = _box(passive, rest, base)
    hulls = [_hull(finger, result.joint_names, passive, rest, low, high) for finger in FINGERS]
    return replace(
        base,
        q_min_rad=low,
        q_max_rad=high,
        hulls=tuple(hull for hull in hulls if hull is not None),
        measured_utc_ns=measured_utc_ns,
        expires_utc_ns=expires_utc_ns,
        wrist_rad=wrist_rad,
    )


def hulls_exceeded(q_rad: Float64, joint_names: tuple[str, ...], hulls: tuple[Hull, ...]) -> Float64:
    """How far postures, (N, J), lie outside each hull, (N, H) rad; negative inside."""
    return np.stack(
        [outside(hull.corners_rad, q_rad[:, _columns(hull, joint_names)]) for hull in hulls], axis=1
    )


def clamp(q_rad: Float64, joint_names: tuple[str, ...], limits: Limits) -> Float64:
    """Postures, (N, J), each moved into the hulls and the box by the shortest way."""
    inside = np.clip(q_rad, limits.q_min_rad, limits.q_max_rad)
    for hull in limits.hulls:
        columns = _columns(hull, joint_names)
        inside[:, columns] = nearest(hull.corners_rad, inside[:, columns])
    return inside


def _check(result: SweepResult, base: Limits, measured_utc_ns: int, expires_utc_ns: int) -> None:
    joints = len(result.joint_names)
    if result.verdict:
        raise Refused("range sweep", result.verdict, "made to its end", "measure the range again")
    if base.q_min_rad.shape != (joints,):
        value, bound = f"for {joints} joints", f"for the {base.q_min_rad.size} of the limits"
        raise Refused("range sweep", value, bound, "measure with this device")
    if not bool(np.isfinite(result.passive_rad).all(axis=1).any() and np.isfinite(result.rest_rad).all()):
        raise Refused("range sweep", "without a posture", "one posture or more", "measure the range again")
    if not measured_utc_ns < expires_utc_ns:
        raise Refused("limits", "expired when measured", "valid until midnight", "check the clock")


def _box(passive: Float64, rest: Float64, base: Limits) -> tuple[Float64, Float64]:
    """Ends of each joint, (J,) and (J,): inset, with the rest posture, inside the base."""
    low, high = passive.min(axis=0), passive.max(axis=0)
    low, high = np.minimum(low, rest), np.maximum(high, rest)
    least = np.clip(0.5 * (high - low), _LEAST_WIDTH_RAD, _USUAL_WIDTH_RAD)
    margin = np.minimum(INSET_RAD, _NARROW_SHARE * (high - low))
    low, high = np.minimum(low + margin, rest), np.maximum(high - margin, rest)
    lacking = 0.5 * np.maximum(least - (high - low), 0.0)
    return np.maximum(low - lacking, base.q_min_rad), np.minimum(high + lacking, base.q_max_rad)


def _hull(
    finger: str, names: tuple[str, ...], passive: Float64, rest: Float64, low: Float64, high: Float64
) -> Hull | None:
    """What MCP flexion and PIP of a finger share; None where the box is as narrow already."""
    joints = (f"{finger}_mcp_flexion", f"{finger}_pip")
    if any(joint not in names for joint in joints):
        return None
    columns = [names.index(joint) for joint in joints]
    points = np.concatenate([passive[:, columns], rest[None, columns]])
    whole = convex_hull(points)
    spans = points.max(axis=0) - points.min(axis=0)
    if float(spans.min()) <= 2.0 * INSET_RAD:
        return None
    margin = INSET_RAD
    while area(whole) > _LEAST_AREA_RAD2 and margin > np.deg2rad(0.5):
        smaller = inset(whole, margin)
        if area(smaller) > _LEAST_AREA_RAD2:
            corners = convex_hull(np.concatenate([smaller, rest[None, columns]]))
            return Hull(joints, within_box(corners, low[columns], high[columns]))
        margin *= 0.5
    raise Refused(
        f"range of {finger} MCP and PIP",
        "a line",
        "an area",
        "measure again with at least three of open, tabletop, hook and fist",
    )


def _columns(hull: Hull, joint_names: tuple[str, ...]) -> list[int]:
    return [joint_names.index(joint) for joint in hull.joints]
