"""What a tone test measured: resistance by speed, and where a catch came. Never a Modified Ashworth grade."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from robot_iface.runtime.sweep_reading import part
from robot_iface.runtime.sweep_tone import STRETCH
from robot_iface.types import Float64, Int64, PhaseChange, SafetyState, Sweep, TickBlock

MIDDLE = (0.25, 0.75)
"""Part of the way, common to all stretches of a joint, over which they are compared."""
CATCH_NM = 0.03
"""A catch is where a fast stretch meets this much more than the slow ones did at the same angle."""
_LEAST_WAY_RAD = float(np.deg2rad(8.0))
_GRID = 60


@dataclass(frozen=True, slots=True)
class ToneResult:
    """What a tone test measured. Angles are of the device's encoders.

    Attributes:
        joint_names: The J joints of the device.
        asked_rad_s: Speed of each of the R stretches, (R,).
        reached_rad_s: Speed that the joint reached, (R, J); NaN where it did not move or broke off.
        resistance_nm: Mean torque against the stretch over the middle of the common way, (R, J).
        catch_rad: Angle of the catch, (R, J); NaN where there was none.
        per_speed_nms_rad: How much resistance rises with speed, (J,); NaN where speeds were too alike.
        per_speed_low: Lower end of its 95 % interval, (J,).
        per_speed_high: Upper end, (J,).
        verdict: Empty, or one sentence why the test is not to be used.
    """

    joint_names: tuple[str, ...]
    asked_rad_s: Float64
    reached_rad_s: Float64
    resistance_nm: Float64
    catch_rad: Float64
    per_speed_nms_rad: Float64
    per_speed_low: Float64
    per_speed_high: Float64
    verdict: str


def tone_result(blocks: Sequence[TickBlock], phases: Sequence[PhaseChange], sweep: Sweep) -> ToneResult:
    """Read a tone test from the messages of its run.

    Args:
        blocks: All ticks of the run.
        phases: All phase changes of the run.
        sweep: What was asked for.
    """
    rows = _stretches(blocks, phases, sweep)
    shape = sweep.goals_rad.shape
    reached, resistance, catch = (np.full(shape, np.nan) for _ in range(3))
    slow = [rows[index] for index in rows if sweep.stretch_rad_s[index] == min(sweep.stretch_rad_s)]
    for joint in range(shape[1]):
        window = _common([one[1][:, joint] for one in rows.values()])
        if window is None:
            continue
        for index, (t_ns, q, load) in rows.items():
            column = (t_ns, q[:, joint], load[:, joint])
            reached[index, joint], resistance[index, joint] = _within(column, *window)
            if slow and sweep.stretch_rad_s[index] > min(sweep.stretch_rad_s):
                usual = [(one[1][:, joint], one[2][:, joint]) for one in slow]
                catch[index, joint] = _catch(column[1:], usual, *window)
    slope, low, high = _per_speed(reached, resistance)
    verdict = "" if any(phase.phase == "done" for phase in phases) else "broken off before its end"
    asked_rad_s = np.array(sweep.stretch_rad_s)
    return ToneResult(sweep.joint_names, asked_rad_s, reached, resistance, catch, slope, low, high, verdict)


def _stretches(
    blocks: Sequence[TickBlock], phases: Sequence[PhaseChange], sweep: Sweep
) -> dict[int, tuple[Int64, Float64, Float64]]:
    """Time, angles and loads of each stretch that the supervisor did not have to interrupt."""
    t_ns: Int64 = np.concatenate([block.t_ns for block in blocks])
    q = np.concatenate([block.q_rad for block in blocks])
    load = np.concatenate([block.tau_interaction_nm for block in blocks])
    well = np.concatenate([block.safety_state for block in blocks]) <= SafetyState.ACTIVE
    found: dict[int, tuple[Int64, Float64, Float64]] = {}
    for index in range(len(sweep.postures)):
        inside = part(t_ns, phases, (STRETCH, index, "robot"))
        if inside.any() and bool(well[inside].all()):
            found[index] = (t_ns[inside], q[inside], load[inside])
    return found


def _common(ways: Sequence[Float64]) -> tuple[float, float, float] | None:
    """The middle of the way that every stretch of a joint made: from, to, and +1 or -1; None of a short one.

    Resistance grows with the angle, so stretches are compared where all of them were.
    """
    if not ways:
        return None
    side = float(np.sign(sum(float(way[-1] - way[0]) for way in ways))) or 1.0
    start = max(side * float(way[0]) for way in ways)
    length = min(side * float(way[-1]) for way in ways) - start
    if length < _LEAST_WAY_RAD:
        return None
    return start + MIDDLE[0] * length, start + MIDDLE[1] * length, side


def _within(
    column: tuple[Int64, Float64, Float64], low: float, high: float, side: float
) -> tuple[float, float]:
    """Speed and opposing torque between two angles."""
    t_ns, q_rad, load_nm = column
    rows = np.flatnonzero((side * q_rad > low) & (side * q_rad < high))
    if rows.size < 2:
        return np.nan, np.nan
    span_s = max(float(t_ns[rows[-1]] - t_ns[rows[0]]) * 1e-9, 1e-9)
    speed = abs(float(q_rad[rows[-1]] - q_rad[rows[0]])) / span_s
    return speed, side * float(load_nm[rows].mean())


def _catch(
    stretch: tuple[Float64, Float64],
    slow: Sequence[tuple[Float64, Float64]],
    low: float,
    high: float,
    side: float,
) -> float:
    """First angle at which a stretch meets CATCH_NM more than the mean of the slow ones; NaN for none."""
    grid = np.linspace(low, high, _GRID)
    usual = np.mean([_along(grid, *one, side) for one in slow], axis=0)
    places = np.flatnonzero(side * (_along(grid, *stretch, side) - usual) > CATCH_NM)
    return side * float(grid[places[0]]) if places.size else np.nan


def _along(grid: Float64, q_rad: Float64, load_nm: Float64, side: float) -> Float64:
    """Torque at the angles of a grid (times side), of a joint that goes one way but for noise."""
    ahead = np.maximum.accumulate(side * q_rad)
    kept = np.flatnonzero(np.diff(ahead, prepend=-np.inf) > 0.0)
    return np.interp(grid, ahead[kept], load_nm[kept])


def _per_speed(reached: Float64, resistance: Float64) -> tuple[Float64, Float64, Float64]:
    """Slope of resistance over speed with its 95 % interval, (J,) each."""
    joints = reached.shape[1]
    slope, low, high = (np.full(joints, np.nan) for _ in range(3))
    for joint in range(joints):
        known = np.isfinite(reached[:, joint]) & np.isfinite(resistance[:, joint])
        x, y = reached[known, joint], resistance[known, joint]
        if x.size < 4 or np.ptp(x) < 0.05:
            continue
        line: Any = stats.linregress(x, y)
        reach = float(stats.t.ppf(0.975, x.size - 2)) * float(line.stderr)
        slope[joint] = line.slope
        low[joint], high[joint] = line.slope - reach, line.slope + reach
    return slope, low, high
