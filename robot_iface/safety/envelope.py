"""Numeric checks of one tick: is every number finite, and is every quantity within its bound?"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, Limits, SafetyState

SENSOR_DIFFERENCE_RAD = float(np.deg2rad(5.0))
TORQUE_CAP_MULTIPLE = 3.0
HARD_LOAD_MULTIPLE = 1.5
APPLIED_SHARE = 0.95
"""Commanded torque is clamped at this share of the interaction limit: what the motor gives, the patient
gets, but
for the device's own friction and inertia (less than 0.01 Nm). The rest is room for noise below the trip."""

_CAUSES: tuple[tuple[str, SafetyState], ...] = (
    ("sensors-differ", SafetyState.CAT0),
    ("range", SafetyState.CAT1),
    ("speed-trip", SafetyState.CAT1),
    ("torque-measured", SafetyState.CAT1),
    ("torque-request", SafetyState.CAT1),
    ("torque-step", SafetyState.CAT1),
    ("power", SafetyState.CAT1),
    ("load-hard", SafetyState.COMPLIANT),
)
_ALWAYS = 1
_RANGE = 1
_LOAD = 7


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that was broken: see ``SafetyEvent`` for the fields."""

    cause: str
    state: SafetyState
    joint: str
    value: float
    bound: float


@dataclass(frozen=True, slots=True)
class Assessment:
    """Numbers of one tick. Arrays are (J,).

    Attributes:
        requested_tau_nm: Torque that the request asks for at the present state.
        applied_tau_nm: The same within the limits.
        load_share: Largest interaction torque as a share of its limit.
        findings: Broken rules, usually none.
    """

    requested_tau_nm: Float64
    applied_tau_nm: Float64
    load_share: float
    findings: tuple[Finding, ...]


class Envelope:
    """Bounds of all joints in one table, compared in one go.

    Args:
        limits: Limits of the driven joints.
        joint_names: Their names.
        period_s: Control period.
    """

    def __init__(self, limits: Limits, joint_names: tuple[str, ...], period_s: float) -> None:
        ones = np.ones(len(joint_names))
        self._names = joint_names
        self.motor_cap_nm: Float64 = limits.tau_nm
        """Clamp of damping torque, (J,)."""
        self.follow_cap_nm: Float64 = np.minimum(limits.tau_nm, APPLIED_SHARE * limits.tau_interaction_nm)
        """Clamp of requested torque at full ramp, (J,)."""
        self._low_rad = limits.q_min_rad
        self._high_rad = limits.q_max_rad
        self._margin_rad = limits.margin_rad
        self._middle_rad: Float64 = 0.5 * (limits.q_min_rad + limits.q_max_rad)
        self._bounds: Float64 = np.stack(
            (
                ones * SENSOR_DIFFERENCE_RAD,
                0.5 * (limits.q_max_rad - limits.q_min_rad) + limits.margin_rad,
                ones * limits.trip_speed_rad_s,
                TORQUE_CAP_MULTIPLE * limits.tau_nm,
                TORQUE_CAP_MULTIPLE * limits.tau_nm,
                ones * limits.tau_rate_nm_s * period_s,
                ones * limits.power_w,
                limits.tau_interaction_nm,
            )
        )
        self._inverse: Float64 = 1.0 / self._bounds
        self._rows: Float64 = np.zeros_like(self._bounds)

    def assess(
        self,
        state: DeviceState,
        request: DeviceCommand,
        previous: DeviceCommand | None,
        cap_nm: Float64,
        *,
        moving: bool,
    ) -> Assessment:
        """Check one tick.

        Args:
            state: Newest reading.
            request: What is to be applied.
            previous: What was requested one tick ago, None if the source of requests has just changed.
            cap_nm: Torque clamp that applies now, (J,).
            moving: Whether the motors pursue a goal; otherwise only trust in the sensors is checked.
        """
        with np.errstate(all="ignore"):
            tau = torque_of(request, state)
            applied = np.minimum(np.maximum(self._inside(request, tau), -cap_nm), cap_nm)
            rows = self._rows
            rows[0] = state.q_rad - state.q_second_rad
            rows[1] = state.q_rad - self._middle_rad
            rows[2] = state.dq_rad_s
            rows[3] = state.tau_nm
            rows[4] = tau
            rows[5] = 0.0 if previous is None else tau - torque_of(previous, state)
            rows[6] = applied * state.dq_rad_s
            rows[7] = state.tau_interaction_nm
            np.abs(rows, out=rows)
            worst: list[float] = (rows * self._inverse).max(axis=1).tolist()
        return Assessment(tau, applied, worst[_LOAD], self._findings(worst, state, moving))

    def _inside(self, request: DeviceCommand, tau_nm: Float64) -> Float64:
        """Torque of the request if its positions, and their speeds outwards, were kept in today's range."""
        if request.mode is CommandMode.TORQUE:
            return tau_nm
        excess = np.minimum(np.maximum(request.q_rad, self._low_rad), self._high_rad) - request.q_rad
        outward = np.where(excess * request.dq_rad_s < 0.0, request.dq_rad_s, 0.0)
        return tau_nm + request.stiffness_nm_rad * excess - request.damping_nms_rad * outward

    def _findings(self, worst: list[float], state: DeviceState, moving: bool) -> tuple[Finding, ...]:
        """Findings from the largest share of the bound in each row."""
        if not math.isfinite(sum(worst)):
            return (self._not_finite(worst),)
        rows = range(len(_CAUSES) if moving else _ALWAYS)
        return tuple(
            self._finding(row, state)
            for row in rows
            if worst[row] > (HARD_LOAD_MULTIPLE if row == _LOAD else 1.0)
        )

    def _finding(self, row: int, reading: DeviceState) -> Finding:
        """Details of a broken row; of the range, the angle itself and the end that it has passed."""
        cause, state = _CAUSES[row]
        joint = int(np.argmax(self._rows[row] * self._inverse[row]))
        if row == _RANGE:
            angle = float(reading.q_rad[joint])
            low, high = self._low_rad[joint] - self._margin_rad, self._high_rad[joint] + self._margin_rad
            return Finding(cause, state, self._names[joint], angle, float(low if angle < low else high))
        bound = float(self._bounds[row, joint]) * (HARD_LOAD_MULTIPLE if row == _LOAD else 1.0)
        return Finding(cause, state, self._names[joint], float(self._rows[row, joint]), bound)

    def _not_finite(self, worst: list[float]) -> Finding:
        """Trust is lost: which number is not finite, of the state or of the command?"""
        of_state = (0, 1, 2, 3, 7)
        in_state = any(not math.isfinite(worst[row]) for row in of_state)
        row = next(row for row, share in enumerate(worst) if not math.isfinite(share))
        joint = int(np.argmax(~np.isfinite(self._rows[row])))
        cause = "state-not-finite" if in_state else "command-not-finite"
        return Finding(cause, SafetyState.CAT0, self._names[joint], math.nan, math.nan)


def torque_of(command: DeviceCommand, state: DeviceState) -> Float64:
    """Torque that a device applies by a command at a state, (J,) Nm."""
    if command.mode is CommandMode.TORQUE:
        return command.tau_ff_nm
    return (
        command.stiffness_nm_rad * (command.q_rad - state.q_rad)
        + command.damping_nms_rad * (command.dq_rad_s - state.dq_rad_s)
        + command.tau_ff_nm
    )
