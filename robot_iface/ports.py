"""What the motion core needs from outside: a hand robot, an emergency stop, a clock."""

from __future__ import annotations

from typing import Protocol

from robot_iface.types import Capabilities, DeviceCommand, DeviceState


class HandRobot(Protocol):
    """A hand robot, real or simulated. Only the safety supervisor holds one for writing."""

    @property
    def capabilities(self) -> Capabilities:
        """What the device is and can do."""
        ...

    def open(self) -> None:
        """Connect; the motors stay unpowered."""
        ...

    def read(self) -> DeviceState:
        """The newest state."""
        ...

    def write(self, command: DeviceCommand) -> None:
        """Apply a command until the next one."""
        ...

    def enable(self) -> None:
        """Power the motors."""
        ...

    def brake(self, damping_nms_rad: float) -> None:
        """Resist motion by damping only, without a position goal."""
        ...

    def power_off(self) -> None:
        """Cut motor power; what the joints then do is ``Capabilities.unpowered``."""
        ...

    def clear_faults(self) -> None:
        """Clear device faults after their cause is gone."""
        ...

    def close(self) -> None:
        """Disconnect; power is cut first."""
        ...


class EmergencyStop(Protocol):
    """The stop that a person presses. Reading it takes no lock and no system call."""

    def pressed(self) -> bool:
        """Whether somebody has pressed stop since the last reset."""
        ...


class Clock(Protocol):
    """Time of the control loop."""

    def now_ns(self) -> int:
        """Monotonic time in ns."""
        ...

    def wait_next_tick(self) -> int:
        """Wait for the next absolute deadline and return how late it is, in ns (simulated: 0)."""
        ...
