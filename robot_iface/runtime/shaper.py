"""Stiffness, feed-forward and set-point that change without pulling the hand or letting it go."""

from __future__ import annotations

import numpy as np

from robot_iface.control import nominal_gains
from robot_iface.control.assist import AHEAD_STOP_RAD
from robot_iface.control.impedance import SPRING_SHARE
from robot_iface.motion import Setpoint
from robot_iface.runtime.kernels import MULTIPLE, TAU, ease, lead, let_go
from robot_iface.safety.hulls import pack_hulls
from robot_iface.types import Float64, Plan

TORQUE_SLEW_NM_S = 0.15
"""Moves a hand of 0.64 Nm/rad (Ashworth 3) at 13 deg/s, below the shipped 15."""
FEED_FORWARD_SLEW_NM_S = 0.5
LEAVE_SLEW_RAD_S = 0.5
SWIFT_RAD_S = 1.0
SWIFT_MULTIPLE = 4.0
"""Above this speed a free hand is damped, at twice the speed as at this multiple: a tremor or a spasm that
nothing holds would else reach the trip speed."""
_SWIFT_S = 0.1
WALL_NM_RAD = 3.0
WALL_RAD = float(np.deg2rad(1.0))
"""Depth at which the wall at an end of the range has its full stiffness."""


class Shaper:
    """The present stiffness, feed-forward and lead, and how they change from tick to tick.

    A stiff hand stands far from where it should be. Raising stiffness there pulls it, and lowering it lets it
    go, at a speed that no limit of the path bounds. So the torque of the spring changes slowly, unless the
    spring is saturated and its torque does not depend on its stiffness.

    Args:
        plan: Prescribed multiple and ramp, and the limits.
        first: First multiple, at most the prescribed one.
        period_s: Control period.
    """

    def __init__(self, plan: Plan, first: float, period_s: float) -> None:
        ordered, names, limits = plan.prescription, plan.joint_names, plan.limits
        self._multiple_step = max(ordered.stiffness_multiple, 1.0) / ordered.ramp_s * period_s
        self._spring_step_nm = TORQUE_SLEW_NM_S * period_s
        self._quick_step_nm = FEED_FORWARD_SLEW_NM_S * period_s
        self._swift_step = SWIFT_MULTIPLE / _SWIFT_S * period_s
        self._lead_step_rad = LEAVE_SLEW_RAD_S * period_s
        slowest = np.minimum(limits.extension_speed_rad_s, limits.flexion_speed_rad_s)
        self._fixed: Float64 = np.stack(
            (
                nominal_gains(names, ordered.space).stiffness_nm_rad,
                SPRING_SHARE * limits.tau_interaction_nm,
                np.minimum(slowest, LEAVE_SLEW_RAD_S) * period_s,
                limits.q_min_rad,
                limits.q_max_rad,
            )
        )
        hulls = pack_hulls(limits, names)
        self._pairs, self._corners = hulls.pairs, hulls.corners_rad
        self._table: Float64 = np.zeros((3, len(names)))
        self._still = np.zeros(len(names))
        self.multiple: Float64 = self._table[MULTIPLE]
        """Multiple of the thesis gains, (J,); changes in place."""
        self.tau_nm: Float64 = self._table[TAU]
        """Feed-forward torque, (J,); changes in place."""
        self._compile()
        self.multiple[:] = min(first, ordered.stiffness_multiple)

    @property
    def stiffness_nm_rad(self) -> Float64:
        """Present stiffness, (J,)."""
        return self._fixed[0] * self.multiple

    def begin_anew(self, multiple: float) -> None:
        """Be no stiffer than this, without feed-forward and lead; only where the hand itself is the goal."""
        np.minimum(self.multiple, multiple, out=self.multiple)
        self._table[TAU:] = 0.0

    def ease(
        self, setpoint: Setpoint, q_rad: Float64, wanted: Float64, wanted_nm: Float64, *, quick: bool
    ) -> None:
        """Go one tick towards a multiple and a feed-forward, (J,); the latter ``quick`` along the path."""
        ease(
            *(self._table, self._fixed, q_rad, setpoint.q_rad, wanted, wanted_nm),
            *(self._multiple_step, self._spring_step_nm),
            self._quick_step_nm if quick else self._spring_step_nm,
        )

    def lead(self, setpoint: Setpoint, q_rad: Float64, heading: Float64, sign: float) -> Setpoint:
        """The set-point, moved to a patient who is ahead where the path is heading, (J,)."""
        out = np.empty(q_rad.size)
        lead(
            *(self._table, self._fixed, q_rad, setpoint.q_rad, heading, sign),
            *(self._lead_step_rad, AHEAD_STOP_RAD, out),
        )
        return Setpoint(out, setpoint.dq_rad_s, setpoint.ddq_rad_s2)

    def let_go(self, q_rad: Float64, dq_rad_s: Float64) -> tuple[Setpoint, Float64]:
        """No goal but the ends of today's range; the set-point and the multiple of this tick."""
        out = np.empty((3, q_rad.size))
        let_go(
            *(self._table, self._fixed, self._pairs, self._corners, q_rad, dq_rad_s),
            *(WALL_NM_RAD, WALL_RAD, SWIFT_RAD_S, SWIFT_MULTIPLE, self._swift_step, out),
        )
        return Setpoint(out[0], out[1], self._still), out[2]

    def _compile(self) -> None:
        """Call everything once, before the first tick."""
        still = np.zeros(self._still.size)
        setpoint = Setpoint(still, still, still)
        self.ease(setpoint, still, still, still, quick=True)
        self.lead(setpoint, still, still, 1.0)
        self.let_go(still, still)
        self._table[:] = 0.0
