"""The joint impedance law with a spring that saturates at what the patient may be loaded with."""

from __future__ import annotations

import numpy as np

from robot_iface.control.gains import Gains
from robot_iface.control.goal import Goal
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, Limits

SPRING_SHARE = 0.9
"""Share of the interaction limit at which the spring saturates: below the trip, so that a stiff hand opens as
far as the limit lets it and the run goes on, instead of tripping in every repetition."""
_SMALL_NM_RAD = 1e-9


class ImpedanceLaw:
    """tau = K (q_d - q) + D (dq_d - dq) + tau_ff, with |K (q_d - q)| <= 0.9 of the interaction limit.

    The saturation moves the commanded position towards the measured one; the recorded command shows it.

    Args:
        gains: Gains at multiple 1, usually ``thesis_gains``.
        limits: Limits of the driven joints.
    """

    def __init__(self, gains: Gains, limits: Limits) -> None:
        self._stiffness = gains.stiffness_nm_rad
        self._damping = gains.damping_nms_rad
        self._spring_nm: Float64 = SPRING_SHARE * limits.tau_interaction_nm

    def command(self, state: DeviceState, goal: Goal, ramp: float, seq: int) -> DeviceCommand:
        """The request of one tick.

        Args:
            state: Newest reading.
            goal: What is asked for.
            ramp: 0 to 1, from ``Supervisor.ramp``: gains and feed-forward rise with it.
            seq: Number of the command.

        Returns:
            An impedance command.
        """
        setpoint, tau_ff_nm = goal.setpoint, goal.tau_ff_nm
        share = goal.multiple * ramp
        stiffness: Float64 = self._stiffness * share
        error = setpoint.q_rad - state.q_rad
        reach = self._spring_nm / (stiffness + _SMALL_NM_RAD)
        error = np.minimum(np.maximum(error, -reach), reach)
        return DeviceCommand(
            mode=CommandMode.IMPEDANCE,
            q_rad=state.q_rad + error,
            dq_rad_s=setpoint.dq_rad_s,
            tau_ff_nm=tau_ff_nm * ramp,
            stiffness_nm_rad=stiffness,
            damping_nms_rad=self._damping * np.sqrt(share),
            seq=seq,
        )
