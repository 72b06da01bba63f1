"""Power, brake and commands of the one device, whatever it answers."""

from __future__ import annotations

from robot_iface.errors import Refused
from robot_iface.ports import HandRobot
from robot_iface.safety.settling import Settling
from robot_iface.safety.yielding import BRAKE_NMS_RAD
from robot_iface.types import DeviceCommand, DeviceState


class Drive:
    """Holds the robot for the supervisor. A device that fails to answer is noted in ``lost``, never raised.

    Args:
        robot: The device.
        period_s: Control period.
    """

    def __init__(self, robot: HandRobot, period_s: float) -> None:
        self.powered = False
        """Whether the motors have power."""
        self.lost = ""
        """What the device failed to do, empty while it answers; cleared by a reset."""
        self._robot = robot
        self._settling = Settling(period_s)
        self._braked_nms_rad = 0.0

    def open(self) -> None:
        """Connect.

        Raises:
            Refused: The device cannot be reached.
        """
        try:
            self._robot.open()
        except OSError as error:
            silent = f"silent ({error.strerror or 'unreachable'})"
            raise Refused("device", silent, "reachable", "check its connection") from error

    def close(self) -> None:
        """Cut power and disconnect; a device that is gone already is left alone."""
        self.cut_power()
        try:
            self._robot.close()
        except OSError as error:
            self.lost = error.strerror or "unreachable"

    def clear_faults(self) -> None:
        """Clear device faults whose cause is gone."""
        self.lost = ""
        try:
            self._robot.clear_faults()
        except OSError as error:
            self.lost = error.strerror or "unwritable"

    def read(self) -> DeviceState | None:
        """The newest state, None if the device cannot be read."""
        try:
            return self._robot.read()
        except OSError as error:
            self.lost = error.strerror or "unreadable"
            return None

    def enable(self) -> None:
        """Power the motors; where that fails nobody knows whether they have it, so it is cut."""
        try:
            self._robot.enable()
            self.powered = True
        except OSError as error:
            self.cut_power()
            self.lost = error.strerror or "unwritable"

    def send(self, command: DeviceCommand) -> None:
        """Write a command; a device that cannot be written is cut off in the next tick."""
        try:
            self._robot.write(command)
        except OSError as error:
            self.lost = error.strerror or "unwritable"

    def begin_brake(self) -> None:
        """From the next ``settle`` on the hand is braked."""
        self._settling.begin()
        self._braked_nms_rad = 0.0

    def brake_now(self) -> None:
        """Damped brake at once; the next ``settle`` goes on with it."""
        self.begin_brake()
        self._brake(BRAKE_NMS_RAD)

    def _brake(self, damping_nms_rad: float) -> None:
        """Damped brake if there is power; where braking fails, power is cut."""
        if not self.powered or damping_nms_rad == self._braked_nms_rad:
            return
        try:
            self._robot.brake(damping_nms_rad)
            self._braked_nms_rad = damping_nms_rad
        except OSError:
            self.cut_power()

    def note(self, load_share: float) -> None:
        """Take the load of one tick; what has pushed hard of late keeps a brake on for longer."""
        self._settling.note(load_share)

    def settle(self, state: DeviceState, damping_nms_rad: float) -> None:
        """One braked tick: power is cut once the hand rests, or has been braked for long enough."""
        self._brake(damping_nms_rad)
        if self._settling.over(state):
            self.cut_power()

    def cut_power(self) -> None:
        """Motors without power."""
        self.powered = False
        try:
            self._robot.power_off()
        except OSError as error:
            self.lost = error.strerror or "unreachable"
