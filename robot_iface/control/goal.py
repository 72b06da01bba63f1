"""What one tick asks of the control law."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from robot_iface.motion import PathState, Setpoint
from robot_iface.types import DeviceCommand, DeviceState, Float64


class Goal(NamedTuple):
    """What one tick asks of the control law; the modes differ in nothing else. Arrays are (J,).

    A tuple, because one is made in every tick.

    Attributes:
        setpoint: Where the joints should be.
        multiple: Stiffness as a multiple of the thesis gains; 0 for none.
        tau_ff_nm: Feed-forward torque.
        path: Where the path stands.
        feedback: Share of the interaction torque that the motors take off the patient (transparent).
        opposition: Share of the interaction limit with which motion is opposed (resistive).
    """

    setpoint: Setpoint
    multiple: Float64
    tau_ff_nm: Float64
    path: PathState
    feedback: float = 0.0
    opposition: float = 0.0


class Law(Protocol):
    """Turns goals into commands."""

    def command(self, state: DeviceState, goal: Goal, ramp: float, seq: int) -> DeviceCommand:
        """The request of one tick.

        Args:
            state: Newest reading.
            goal: What is asked for.
            ramp: 0 to 1, from ``Supervisor.ramp``: gains and feed-forward rise with it.
            seq: Number of the command.
        """
        ...
