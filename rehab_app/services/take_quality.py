"""How well a take was seen, and what two takes look like joint by joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.recording.take import HandMotion
from robot_iface.types import DIGITS, JOINTS
from sessions.records import Status
from sessions.records.fields import Float64

_MOVES_RAD = float(np.deg2rad(8.0))
_WELL_SEEN, _SEEN = 0.9, 0.6
_FITS_M = 0.004


@dataclass(frozen=True, slots=True)
class TakeQuality:
    """Figures of a take.

    Attributes:
        frames: Number of frames.
        rate_hz: Frames a second.
        measured: Share of joint angles that was measured, 0 to 1.
        estimated: Share that was only estimated.
        lost: Share that was lost.
        longest_gap_s: Longest time for which some joint was not measured.
        residual_m: Median distance of the fitted hand from the seen markers; NaN where none is stated.
        moving: Joints that move by more than 8 degrees, with their range (low, high) in rad.
    """

    frames: int
    rate_hz: float
    measured: float
    estimated: float
    lost: float
    longest_gap_s: float
    residual_m: float
    moving: tuple[tuple[str, float, float], ...]

    @property
    def verdict(self) -> str:
        """In one word: "good", "usable" or "poor"."""
        fits = not self.residual_m > _FITS_M  # NaN: a take of another system states none
        if self.measured >= _WELL_SEEN and fits:
            return "good"
        return "usable" if self.measured + self.estimated >= _SEEN else "poor"


def quality_of(motion: HandMotion) -> TakeQuality:
    """Figures of a take's movement."""
    status = motion.joint_status
    span_s = float(motion.t_s[-1])
    residual = motion.residual_m[np.isfinite(motion.residual_m)]
    return TakeQuality(
        frames=len(motion.t_s),
        rate_hz=(len(motion.t_s) - 1) / span_s,
        measured=float(np.mean(status == Status.MEASURED)),
        estimated=float(np.mean(status == Status.ESTIMATED)),
        lost=float(np.mean(status == Status.LOST)),
        longest_gap_s=_longest_gap_s(motion),
        residual_m=float(np.median(residual)) if residual.size else float("nan"),
        moving=_moving(motion.joints_rad),
    )


def flexion_joints(digit: str) -> tuple[str, ...]:
    """The joints of a digit that bend, from the palm out."""
    if digit == "thumb":
        return ("thumb_cmc_flexion", "thumb_mcp_flexion", "thumb_ip")
    return (f"{digit}_mcp_flexion", f"{digit}_pip", f"{digit}_dip")


def _longest_gap_s(motion: HandMotion) -> float:
    """Longest run of frames without a measurement of a joint that is measured at all."""
    longest = 0.0
    for column in motion.joint_status.T:
        seen = np.flatnonzero(column == Status.MEASURED)
        if seen.size > 1:
            longest = max(longest, float(np.diff(motion.t_s[seen])[np.diff(seen) > 1].max(initial=0.0)))
    return longest


def _moving(joints_rad: Float64) -> tuple[tuple[str, float, float], ...]:
    found: list[tuple[str, float, float]] = []
    for digit in DIGITS:
        for name in flexion_joints(digit):
            angles = joints_rad[:, JOINTS.index(name)]
            seen = angles[np.isfinite(angles)]
            if seen.size and float(np.ptp(seen)) > _MOVES_RAD:
                found.append((name, float(seen.min()), float(seen.max())))
    return tuple(found)
