"""Today's passive curve: what torque a hand that does nothing asks for, by joint, angle and direction.

Recoil and spasm look like effort. What the robot needed to move the same hand on the same day while it did
nothing is taken off, and what remains is the patient's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sessions.metrics.effort import MOVED_RAD, work_share
from sessions.metrics.metric import Z95, Estimate
from sessions.records.fields import Float64

BIN_RAD = math.radians(2.0)
STILL_RAD_S = math.radians(1.0)
"""Slower than this there is no direction, and no work."""
FEWEST = 3
"""Steps of 10 ms that a cell of the curve needs; each is the mean of ten ticks at 1 kHz."""
FEWEST_STEPS = 100
"""Steps that the whole curve needs, 1 s of movement: its scatter is then known to some 7 percent."""
FEWEST_CELLS = 3
"""Cells that it needs in either direction: 6 degrees there and back."""
COVERED = 0.9
"""Part of the moving samples that the curve must know, or nothing is separated."""
NOT_COVERED = "not separable: the passive curve of this day does not reach as far"


@dataclass(frozen=True, slots=True)
class PassiveCurve:
    """Torque of a passive joint.

    Attributes:
        first_bin: Number of the first cell of 2 degrees.
        torque_nm: Median torque by direction (extension, flexion) and cell, shape (2, B); NaN where unknown.
        spread_nm: Standard deviation about it over the whole curve.
    """

    first_bin: int
    torque_nm: Float64
    spread_nm: float

    def at(self, q_rad: Float64, dq_rad_s: Float64) -> Float64:
        """Torque that the passive joint would ask for, shape (N,); NaN beyond what was measured."""
        cell = np.floor(q_rad / BIN_RAD).astype(np.int64) - self.first_bin
        known = (cell >= 0) & (cell < self.torque_nm.shape[1])
        row = (dq_rad_s > 0.0).astype(np.int64)
        return np.where(known, self.torque_nm[row, np.clip(cell, 0, self.torque_nm.shape[1] - 1)], math.nan)


@dataclass(frozen=True, slots=True)
class OwnWork:
    """What one joint's patient did, the passive curve taken off.

    Attributes:
        share: The robot's share.
        robot_j: Work of the robot along the movement.
        patient_j: Work along the movement.
        resisting_j: Work against the movement, negative.
    """

    share: Estimate
    robot_j: Estimate
    patient_j: Estimate
    resisting_j: Estimate


def passive_curve(q_rad: Float64, dq_rad_s: Float64, tau_nm: Float64) -> PassiveCurve | None:
    """The curve of one joint from a passive run, None where it moved too little or was met too seldom.

    A cell needs ``FEWEST`` steps, the curve ``FEWEST_STEPS`` in such cells and ``FEWEST_CELLS`` of them each
    way: the torque of a few samples, and their scatter, would be taken for the limb's.

    Args:
        q_rad: Angles, shape (N,).
        dq_rad_s: Speeds, shape (N,).
        tau_nm: Torque of the robot on the joint, shape (N,), NaN where not measured.
    """
    used = np.isfinite(tau_nm) & np.isfinite(q_rad) & (np.abs(dq_rad_s) >= STILL_RAD_S)
    if not bool(used.any()) or float(np.ptp(q_rad[used])) < MOVED_RAD:
        return None
    cell = np.floor(q_rad[used] / BIN_RAD).astype(np.int64)
    first = int(cell.min())
    torque = np.full((2, int(cell.max()) - first + 1), math.nan)
    row, tau = (dq_rad_s[used] > 0.0).astype(np.int64), tau_nm[used]
    rest = np.full(tau.size, math.nan)
    for direction in (0, 1):
        for number in np.unique(cell[row == direction]):
            chosen = (row == direction) & (cell == number)
            if np.count_nonzero(chosen) >= FEWEST:
                torque[direction, number - first] = np.median(tau[chosen])
                rest[chosen] = tau[chosen] - torque[direction, number - first]
    met = np.isfinite(rest)
    few = np.count_nonzero(met) < FEWEST_STEPS
    if few or int(np.isfinite(torque).sum(axis=1).min()) < FEWEST_CELLS:
        return None
    return PassiveCurve(first, torque, float(np.sqrt(np.mean(rest[met] ** 2))))


def own_work(
    t_s: Float64, q_rad: Float64, dq_rad_s: Float64, tau_nm: Float64, curve: PassiveCurve
) -> OwnWork:
    """Work of one joint, separated.

    A torque within 1.96 spreads of the curve is taken for none: noise would count as work otherwise. The
    interval of the share runs between the curve one spread too high and one too low all the time.

    Args:
        t_s: Times, shape (N,).
        q_rad: Angles, shape (N,).
        dq_rad_s: Speeds, shape (N,).
        tau_nm: Torque of the robot on the joint, shape (N,).
        curve: The passive curve of that joint, day and device.
    """
    own = curve.at(q_rad, dq_rad_s) - tau_nm
    moving = np.abs(dq_rad_s) >= STILL_RAD_S
    known = moving & np.isfinite(own)
    if not bool(moving.any()):
        missing = Estimate.missing("the joint did not move")
        return OwnWork(missing, missing, missing, missing)
    if np.count_nonzero(known) < COVERED * np.count_nonzero(moving):
        missing = Estimate.missing(NOT_COVERED)
        return OwnWork(missing, missing, missing, missing)
    step = np.diff(t_s, append=t_s[-1])
    rate = np.where(known, dq_rad_s * np.minimum(step, 3.0 * float(np.median(step))), 0.0)
    tau, own = np.where(known, tau_nm, 0.0), np.where(known, own, 0.0)
    shifts = (0.0, -curve.spread_nm, curve.spread_nm)
    parts = [_parts(tau, np.where(known, own + shift, 0.0), rate, Z95 * curve.spread_nm) for shift in shifts]
    return OwnWork(*(_between([part[column] for part in parts]) for column in range(4)))


def _parts(
    tau: Float64, own: Float64, travel: Float64, dead_nm: float
) -> tuple[Estimate, Estimate, Estimate, Estimate]:
    """Share, robot's work, patient's work along and against; ``travel`` is the angle passed in each step."""
    kept = np.where(np.abs(own) > dead_nm, own, 0.0)
    energy = kept * travel
    return (
        work_share(tau, kept, travel),
        Estimate(float(np.sum(np.maximum(0.0, tau * travel)))),
        Estimate(float(energy[energy > 0.0].sum())),
        Estimate(float(energy[energy < 0.0].sum())),
    )


def _between(cases: list[Estimate]) -> Estimate:
    values = [case.value for case in cases]
    if not all(math.isfinite(value) for value in values):
        return cases[0] if not math.isfinite(cases[0].value) else Estimate(cases[0].value)
    return Estimate(values[0], (min(values), max(values)))
