"""What a fit check found: does every joint follow, the right way round, as softly as this hand does?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robot_iface.runtime.sweep_reading import part
from robot_iface.types import Float64, Int64, PhaseChange, RunEnd, SafetyState, Sweep, TickBlock

FAILED = "fit: "
"""What the reason of a run begins with whose check has failed."""
FOLLOWS_SHARE = 0.15
"""Least movement of a joint as a share of what was asked: less is blocked, or not connected."""
OPPOSES_NM_RAD = 0.005
"""A hand that seems to push along by more than this per angle has its load measured with the wrong sign."""
STIFFEST_NM_RAD = 1.1
"""Stiffest joint of a hand without a record: 0.9 Nm/rad is the stiffest of the literature (clinical.md)."""
RECORD_LEAST, RECORD_MOST, RECORD_MORE_NM_RAD = 0.5, 1.8, 0.03
"""How much softer or stiffer than its record a hand may feel: beyond it the axes are suspected first, because
a strap that slides along the bone takes part of the movement up or adds its own stiffness."""
NEUTRAL_RAD = float(np.deg2rad(8.0))
STICKS_NM = 0.03
"""Largest load that depends on the direction alone."""
_TREMOR_S = 0.2  # a mean over this time leaves nothing of a tremor of 5 Hz
_MOVING_RAD_S = float(np.deg2rad(1.0))


@dataclass(frozen=True, slots=True)
class FitResult:
    """What a fit check measured by joint, arrays (J,); NaN for joints that were not reached.

    Attributes:
        joint_names: The J joints of the device.
        gain: Measured movement per movement asked for.
        stiffness_nm_rad: Load per angle, as the device feels the hand.
        sticking_nm: Load that depends on the direction of movement alone.
        neutral_rad: Angle at which the joint would carry no load.
        verdict: Empty, or the sentence that says which joint does not fit, the value, bound and remedy.
    """

    joint_names: tuple[str, ...]
    gain: Float64
    stiffness_nm_rad: Float64
    sticking_nm: Float64
    neutral_rad: Float64
    verdict: str


def fit_result(
    blocks: Sequence[TickBlock],
    phases: Sequence[PhaseChange],
    end: RunEnd,
    sweep: Sweep,
    recorded_nm_rad: float,
    usual_neutral_rad: Float64 | None = None,
) -> FitResult:
    """The outcome of a fit check, read from the messages of its run.

    What no reading of the device alone can show: straps that slipped before the first look at this hand, and
    zeros that are wrong in both sensors alike. Only the neutral posture of an earlier session shows them.

    Args:
        blocks: All ticks of the run.
        phases: All phase changes of the run.
        end: How the run ended.
        sweep: What was asked for.
        recorded_nm_rad: Stiffness of the patient's record (``PatientTwin.stiffness_nm_rad``), 0 for none.
        usual_neutral_rad: ``neutral_rad`` of an earlier session with this patient and device, (J,), if any.
    """
    columns = ("q_reference_rad", "q_rad", "tau_interaction_nm")
    asked, q, tau = (np.concatenate([getattr(block, name) for block in blocks]) for name in columns)
    t_ns: Int64 = np.concatenate([block.t_ns for block in blocks])
    states = np.concatenate([block.safety_state for block in blocks])
    groups = sorted({phase.repetition for phase in phases if phase.phase == "check"})
    moved = np.zeros((4, len(sweep.joint_names))) + np.nan
    for group in groups:
        inside = part(t_ns, phases, ("check", group, "robot")) & (states <= SafetyState.ACTIVE)
        found = measure(asked[inside], q[inside], tau[inside], _step_s(t_ns))
        moved = np.where(np.isnan(moved), found, moved)
    verdict = _verdict(sweep.joint_names, moved, end, recorded_nm_rad)
    if not verdict and usual_neutral_rad is not None:
        verdict = _displaced(sweep.joint_names, moved[3] - usual_neutral_rad)
    gain, stiffness, sticking, neutral = moved
    return FitResult(sweep.joint_names, gain, stiffness, sticking, neutral, verdict)


def _verdict(names: tuple[str, ...], found: Float64, end: RunEnd, recorded_nm_rad: float) -> str:
    """What the run itself said, else what its numbers say."""
    if end.reason.startswith(FAILED):
        return end.reason.removeprefix(FAILED)
    unfit = verdict_of(names, found, recorded_nm_rad)
    if unfit:
        return unfit
    if not end.completed:
        cause = end.reason or end.state.name
        return f"the fit check was ended by {cause}, but must be made to its end: look at the hand and repeat"
    if bool(np.isnan(found).any()):
        missing = names[int(np.argmax(np.isnan(found).any(axis=0)))]
        return f"{missing} was not checked, but every joint must be: make the fit check again"
    return ""


def _displaced(names: tuple[str, ...], moved_rad: Float64) -> str:
    """The joint whose neutral angle is another one than usual, empty if none is."""
    moved_rad = np.where(np.isfinite(moved_rad), moved_rad, 0.0)  # what was not measured then says nothing
    joint = int(np.argmax(np.abs(moved_rad)))
    if not abs(moved_rad[joint]) > NEUTRAL_RAD:
        return ""
    value, bound = np.rad2deg(abs(moved_rad[joint])), np.rad2deg(NEUTRAL_RAD)
    return f"{names[joint]} rests {value:.0f}° from its usual place, bound {bound:.0f}°: seat the hand again"


def measure(asked_rad: Float64, q_rad: Float64, tau_nm: Float64, step_s: float) -> Float64:
    """Gain, stiffness, sticking and neutral angle of each joint from one group's movement.

    Args:
        asked_rad: Where the joints were led, (n, J).
        q_rad: Where they were measured, (n, J).
        tau_nm: Interaction torque, (n, J).
        step_s: Time between the rows.

    Returns:
        Rows in that order, (4, J); NaN for joints that were not led anywhere.
    """
    found = np.full((4, q_rad.shape[1]), np.nan)
    window = round(_TREMOR_S / step_s)
    if len(q_rad) < 2 * window:
        return found
    asked_rad, q_rad, tau_nm = (_smoothed(rows, window) for rows in (asked_rad, q_rad, tau_nm))
    steps = np.diff(asked_rad, axis=0, prepend=asked_rad[:1])
    for joint in np.flatnonzero(np.ptp(asked_rad, axis=0) > np.deg2rad(2.0)):
        asked, q, tau = asked_rad[:, joint], q_rad[:, joint], tau_nm[:, joint]
        way = np.sign(steps[:, joint]) * (np.abs(steps[:, joint]) > step_s * _MOVING_RAD_S)
        centred = asked - asked.mean()
        found[0, joint] = float(centred @ q / (centred @ centred))
        middle = float(q.mean())
        table = np.stack([np.ones(len(q)), q - middle, way], axis=1)
        level, slope, sticking = np.linalg.lstsq(table, tau, rcond=None)[0]
        found[1:3, joint] = slope, sticking
        found[3, joint] = middle - level / slope if slope > 0.0 else np.nan
    found[3] = np.where(np.isnan(found[3]) & ~np.isnan(found[1]), 0.0, found[3])
    return found


def _smoothed(rows: Float64, window: int) -> Float64:
    """Mean over so many rows that follow each other, (n, J) -> (n - window + 1, J)."""
    sums = np.cumsum(np.concatenate([np.zeros((1, rows.shape[1])), rows]), axis=0)
    return (sums[window:] - sums[:-window]) / window


def _step_s(t_ns: Int64) -> float:
    return float(np.median(np.diff(t_ns))) * 1e-9


def verdict_of(joint_names: tuple[str, ...], found: Float64, recorded_nm_rad: float) -> str:
    """The first joint that does not fit as a sentence, empty if all that were measured do.

    Args:
        joint_names: The J joints.
        found: What ``measure`` found, (4, J).
        recorded_nm_rad: Stiffness of the patient's record, 0 for none.
    """
    known = recorded_nm_rad > 0.0
    most = RECORD_MOST * recorded_nm_rad + RECORD_MORE_NM_RAD if known else STIFFEST_NM_RAD
    bounds = (RECORD_LEAST * recorded_nm_rad, most)
    for name, (gain, stiffness, sticking, _) in zip(joint_names, found.T.tolist(), strict=True):
        if np.isnan(gain):
            continue
        text = _unfit(gain, stiffness, sticking, bounds)
        if text:
            return f"{name} {text}"
    return ""


def _unfit(gain: float, stiffness: float, sticking: float, bounds: tuple[float, float]) -> str:
    """Why one joint does not fit, empty if it does."""
    if gain < 0.0:
        return f"moves by {gain:.2f} of what is asked, but must follow it: its sensor or motor is reversed"
    if gain < FOLLOWS_SHARE:
        return f"moves by {gain:.2f} of what is asked, bound {FOLLOWS_SHARE:.2f}: free it and repeat"
    if stiffness < -OPPOSES_NM_RAD:
        return (
            f"seems to push along with {-stiffness:.3f} Nm/rad, but must oppose: "
            "its torque sensor is reversed or the patient moved, check and repeat"
        )
    if not bounds[0] <= stiffness <= bounds[1]:
        span = f"{bounds[0]:.2f} to {bounds[1]:.2f}"
        return (
            f"feels as stiff as {stiffness:.3f} Nm/rad, bound {span} by the patient's record: "
            "align the axes, tighten the straps and repeat"
        )
    if abs(sticking) > STICKS_NM:
        return (
            f"sticks with {abs(sticking):.3f} Nm, bound {STICKS_NM:.3f}: "
            "loosen what rubs, align the axes and repeat"
        )
    return ""
