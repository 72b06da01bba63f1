"""Checks of one tick: is every number finite, and is every quantity within its bound?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robot_iface.safety import kernels
from robot_iface.safety.hulls import pack_hulls
from robot_iface.safety.passivity import LIMIT_J, kept_share, renewed_share
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, Limits, SafetyState

SENSOR_DIFFERENCE_RAD = float(np.deg2rad(5.0))
TORQUE_CAP_MULTIPLE = 3.0
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
    ("hull", SafetyState.CAT1),
    ("passivity", SafetyState.COMPLIANT),
)
_ALWAYS = 1 << kernels.SENSORS
_OF_STATE = (
    *(kernels.SENSORS, kernels.RANGE, kernels.SPEED, kernels.TORQUE),
    *(kernels.LOAD, kernels.COUPLED, kernels.ENERGY),
)
_SMALLEST_RAD = 1e-9
_REQUESTED, _CLAMPED, _CHANGED = kernels.REQUESTED, kernels.CLAMPED, kernels.CHANGED
_TORQUE = CommandMode.TORQUE


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that was broken: see ``SafetyEvent`` for the fields."""

    cause: str
    state: SafetyState
    joint: str
    value: float
    bound: float


class Assessment(NamedTuple):
    """Numbers of one tick; a tuple, because one is made in every tick. Arrays are (J,).

    Attributes:
        requested_tau_nm: Torque that the request asks for at the present state.
        applied_tau_nm: The same within the limits.
        applied: The request within the limits: itself, where nothing had to be changed.
        load_share: Largest interaction torque as a share of its limit.
        commanded_rad_s: Highest commanded speed.
        speed_rad_s: Highest measured speed.
        findings: Broken rules, usually none.
    """

    requested_tau_nm: Float64
    applied_tau_nm: Float64
    applied: DeviceCommand
    load_share: float
    commanded_rad_s: float
    speed_rad_s: float
    findings: tuple[Finding, ...]


class Envelope:
    """Bounds of all joints in one table, compared in one compiled call.

    Args:
        limits: Limits of the driven joints.
        joint_names: Their names.
        period_s: Control period.

    Raises:
        Refused: A hull does not fit the joints or today's range.
    """

    def __init__(self, limits: Limits, joint_names: tuple[str, ...], period_s: float) -> None:
        self._names = joint_names
        self.motor_cap_nm: Float64 = np.ascontiguousarray(limits.tau_nm, dtype=np.float64)
        """Clamp of damping torque, (J,)."""
        self.follow_cap_nm: Float64 = np.minimum(limits.tau_nm, APPLIED_SHARE * limits.tau_interaction_nm)
        """Clamp of requested torque at full ramp, (J,)."""
        self._margin_rad = limits.margin_rad
        self._hulls = hulls = pack_hulls(limits, joint_names)
        self._pairs, self._corners = hulls.pairs, hulls.corners_rad
        self._table = _table(limits, period_s)
        joints = len(joint_names)
        self._given: Float64 = np.zeros((kernels.INPUT_ROWS, joints))
        self._work: Float64 = np.zeros((kernels.WORK_ROWS, joints))
        self._shape = (kernels.OUT_ROWS, joints)
        self._warm_up()

    def _warm_up(self) -> None:
        """Call the kernel once, so that it is compiled before the first tick."""
        zeros, out = np.zeros(self._shape[1]), np.zeros(self._shape)
        kernels.assess(
            *(zeros, zeros, zeros, zeros, zeros),  # the reading
            *(zeros, zeros, zeros, zeros, zeros),  # and the request
            *(self._given, False, False, False, zeros, self._table),
            *(self._pairs, self._corners, self._work, out),
        )

    def assess(
        self,
        state: DeviceState,
        request: DeviceCommand,
        cap_nm: Float64,
        *,
        stepped: bool = False,
        continued: bool = False,
        moving: bool = False,
    ) -> Assessment:
        """Check one tick.

        Args:
            state: Newest reading.
            request: What is to be applied.
            cap_nm: Torque clamp that applies now, (J,).
            stepped: Whether the last request came from the same source, so that the step between is checked.
            continued: Whether the request of the last call is what the device has applied since.
            moving: Whether the motors pursue a goal; otherwise only trust in the sensors is checked.
        """
        out: Float64 = np.empty(self._shape)
        bits, load, commanded, speed = kernels.assess(
            state.q_rad,
            state.q_second_rad,
            state.dq_rad_s,
            state.tau_nm,
            state.tau_interaction_nm,
            request.q_rad,
            request.dq_rad_s,
            request.tau_ff_nm,
            request.stiffness_nm_rad,
            request.damping_nms_rad,
            self._given,
            request.mode is _TORQUE,
            stepped,
            continued,
            cap_nm,
            self._table,
            self._pairs,
            self._corners,
            self._work,
            out,
        )
        applied = request
        if bits & _CHANGED:
            bits ^= _CHANGED
            applied = _within(request, out)
        findings = self._findings(bits, moving=moving) if bits else ()
        return Assessment(out[_REQUESTED], out[_CLAMPED], applied, load, commanded, speed, findings)

    def load(self) -> Finding:
        """The largest load of the last call, as a finding: joint, torque and its limit."""
        limits = self._table[kernels.BOUNDS + kernels.LOAD]
        joint = int(np.argmax(self._work[kernels.LOAD] / limits))
        torque, limit = float(self._work[kernels.LOAD, joint]), float(limits[joint])
        return Finding("load", SafetyState.COMPLIANT, self._names[joint], torque, limit)

    def _findings(self, bits: int, *, moving: bool) -> tuple[Finding, ...]:
        """Findings from the bits of the kernel."""
        if bits & kernels.NOT_FINITE:
            return (self._not_finite(),)
        if not moving:
            bits &= _ALWAYS
        return tuple(self._finding(rule) for rule in range(len(_CAUSES)) if bits >> rule & 1)

    def _finding(self, rule: int) -> Finding:
        """Details of a broken rule; of a range, the angle itself and the end that it has passed."""
        cause, state = _CAUSES[rule]
        bounds = self._table[kernels.BOUNDS + rule]
        joint = int(np.argmax(self._work[rule] / bounds))
        name, angle = self._names[joint], float(self._given[kernels.Q, joint])
        if rule in (kernels.RANGE, kernels.COUPLED):
            return Finding(cause, state, name, angle, self._end(rule, joint, angle))
        bound = float(bounds[joint]) * (kernels.HARD_LOAD_MULTIPLE if rule == kernels.LOAD else 1.0)
        return Finding(cause, state, name, float(self._work[rule, joint]), bound)

    def _end(self, rule: int, joint: int, angle_rad: float) -> float:
        """The end of the range that an angle has passed, with the margin."""
        if rule == kernels.COUPLED:
            nearest = float(self._hulls.pulled_in(self._given[kernels.Q])[joint])
            return nearest + math.copysign(self._margin_rad, angle_rad - nearest)
        low, high = self._table[kernels.LOW, joint], self._table[kernels.HIGH, joint]
        if angle_rad < 0.5 * (low + high):
            return float(low - self._margin_rad)
        return float(high + self._margin_rad)

    def _not_finite(self) -> Finding:
        """Trust is lost: which number is not finite, of the state or of the command?"""
        rules = self._work[: len(_CAUSES)]
        bad = ~np.isfinite(rules / self._table[kernels.BOUNDS :])
        in_state = bool(bad[list(_OF_STATE)].any())
        joint = int(np.argmax(bad[int(np.argmax(bad.any(axis=1)))]))
        cause = "state-not-finite" if in_state else "command-not-finite"
        return Finding(cause, SafetyState.CAT0, self._names[joint], math.nan, math.nan)


def _table(limits: Limits, period_s: float) -> Float64:
    """The rows of ``kernels``: ends of the range, constants of the observer, one row of bounds a rule."""
    ones = np.ones(limits.q_min_rad.size)
    return np.stack(
        (
            *(limits.q_min_rad, limits.q_max_rad),
            *(ones * period_s, ones * renewed_share(period_s), ones * kept_share(period_s)),
            ones * SENSOR_DIFFERENCE_RAD,
            0.5 * (limits.q_max_rad - limits.q_min_rad) + limits.margin_rad,
            ones * limits.trip_speed_rad_s,
            TORQUE_CAP_MULTIPLE * limits.tau_nm,
            TORQUE_CAP_MULTIPLE * limits.tau_nm,
            ones * limits.tau_rate_nm_s * period_s,
            ones * limits.power_w,
            limits.tau_interaction_nm,
            ones * max(limits.margin_rad, _SMALLEST_RAD),
            ones * LIMIT_J,
        )
    )


def _within(request: DeviceCommand, out: Float64) -> DeviceCommand:
    """The request with positions and speeds in the range and the torque within its clamp."""
    if request.mode is CommandMode.TORQUE:
        q, dq = request.q_rad, request.dq_rad_s
    else:
        q, dq = out[kernels.PULLED_Q], out[kernels.PULLED_DQ]
    stiffness, damping = request.stiffness_nm_rad, request.damping_nms_rad
    return DeviceCommand(request.mode, q, dq, out[kernels.SHIFTED], stiffness, damping, request.seq)
