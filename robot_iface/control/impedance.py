"""The joint impedance law with a spring that saturates at what the patient may be loaded with."""

from __future__ import annotations

import numpy as np

from robot_iface.control.coupling import SPRING_SHARE, Coupling
from robot_iface.control.gains import Gains
from robot_iface.control.goal import Goal
from robot_iface.control.kernels import joint_impedance
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, Limits

__all__ = ["SPRING_SHARE", "ImpedanceLaw"]


class ImpedanceLaw:
    """tau = K (q_d - q) + D (dq_d - dq) + tau_ff, with |K (q_d - q)| <= 0.9 of the interaction limit.

    The saturation moves the commanded position towards the measured one; the recorded command shows it.
    Torque feedback (``Goal.feedback``) is part of the command's feed-forward, opposition
    (``Goal.opposition``) of its damping, so that clamp, rate check and record of the supervisor see all of
    it.

    Args:
        gains: Gains at multiple 1, usually ``thesis_gains``.
        limits: Limits of the driven joints.
        period_s: Control period.
    """

    def __init__(self, gains: Gains, limits: Limits, period_s: float = 1e-3) -> None:
        self._coupling = Coupling(gains, limits, period_s)
        self._shape = (5, gains.stiffness_nm_rad.size)
        rows: Float64 = np.zeros(self._shape)
        table, still = self._coupling.table, rows[0]
        asked = self._coupling.asked(0.0, 0.0, 0.0)
        joint_impedance(rows, still, still, still, still, still, still, still, table, asked)  # compiles it

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
        coupling, setpoint = self._coupling, goal.setpoint
        rows: Float64 = np.empty(self._shape)
        joint_impedance(
            rows,
            state.q_rad,
            state.dq_rad_s,
            state.tau_interaction_nm,
            setpoint.q_rad,
            setpoint.dq_rad_s,
            goal.multiple,
            goal.tau_ff_nm,
            coupling.table,
            coupling.asked(ramp, goal.feedback, goal.opposition),
        )
        return DeviceCommand(CommandMode.IMPEDANCE, rows[0], rows[1], rows[2], rows[3], rows[4], seq)
