"""A real hand behind a ROS 2 driver, through DDS alone: no ROS installation is needed."""

from __future__ import annotations

import errno
import time
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from robot_iface.adapters.device_file import Device
from robot_iface.adapters.joint_map import JointMap
from robot_iface.adapters.kernels import impedance_torque
from robot_iface.adapters.lease import Lease
from robot_iface.adapters.ros2_bus import Bus
from robot_iface.errors import Refused
from robot_iface.types import Capabilities, CommandMode, DeviceCommand, DeviceState, Float64

ANSWER_S = 5.0
"""How long a device may take to be found."""
SETTLE_S = 0.3
"""After it is found: others that command it are found by then, too."""
_LOOK_S = 0.01
_SAY_OFF_EVERY_READS = 25


class Ros2Hand:
    """A hand robot behind a ROS 2 driver.

    With ``command = "effort"`` the impedance law is computed here and its torque is sent. With "trajectory"
    the same torque becomes the position at which the driver's own position control, a spring of
    ``servo_nm_rad``, gives just that torque; a device that is not worn and declares no such spring is sent
    the desired positions themselves. Nothing is sent without power, and power is switched on once for
    each ``enable``: a driver that has switched itself off stays off.

    Args:
        device: The device file.
        now_ns: The monotonic clock of the control loop.
    """

    def __init__(self, device: Device, now_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self.device = device
        """Its device file."""
        self._now_ns = now_ns
        self.capabilities: Capabilities = device.capabilities
        """What the device file says of it."""
        joints = len(device.joint)
        self._map = JointMap(device)
        self._cap_nm = self.capabilities.tau_max_nm
        servo: Float64 = np.array([joint.servo_nm_rad for joint in device.joint])
        self._servo_nm_rad = servo if bool((servo > 0.0).all()) else None
        self._torque_nm: Float64 = np.zeros(joints)
        self._zeros: Float64 = np.zeros(joints)
        self._bus: Bus | None = None
        self._lease: Lease | None = None
        self._state: DeviceState | None = None
        self._faults: tuple[str, ...] = ()
        self._powered = False
        self._brake_nms_rad: float | None = None
        self._reads = 0
        self._goal: Float64 = np.zeros((5, joints))
        zeros = self._zeros
        impedance_torque(self._goal, zeros, zeros, self._cap_nm, self._torque_nm)  # compiled before it moves

    def open(self) -> None:
        """Find the device and its first reading; the motors stay unpowered.

        Raises:
            Refused: Another process has it, nobody answers, its driver does not report what the device file
                says, or somebody else on the network commands it.
        """
        name = self.capabilities.name
        self._lease = Lease(name)
        try:
            self._bus = Bus(self.device)
            self._find(self._bus)
        except (Refused, OSError) as error:
            self.close()
            if isinstance(error, Refused):
                raise
            value = error.strerror or "unreachable"
            remedy = "check cable, interface and domain in its device file"
            raise Refused(f"device {name}", value, "reachable", remedy) from error

    def read(self) -> DeviceState:
        """The newest reading; its time is when it was received. A braked device is braked anew by each.

        Raises:
            OSError: The device is not open, or reports no longer what it should.
        """
        bus = self._opened()
        text = bus.take_faults()
        if text is not None:
            self._faults = tuple(part.strip() for part in text.split(",") if part.strip())
        message = bus.take_state()
        if message is not None:
            seq = 0 if self._state is None else self._state.seq + 1
            self._state = self._map.state(message, self._now_ns(), seq, self._faults)
        if self._state is None:
            raise OSError(errno.ENODATA, "no joint state yet")
        self._reads += 1
        if self._powered and self._brake_nms_rad is not None:
            self._push(bus, self._state, self._brake_nms_rad)
        elif not self._powered and self._reads % _SAY_OFF_EVERY_READS == 0:
            bus.send_power(False)
        return self._state

    def write(self, command: DeviceCommand) -> None:
        """Send what a command asks for at the newest reading; nothing without power.

        Raises:
            OSError: The device is not open or unreachable, or the command holds something that is no number.
        """
        bus = self._opened()
        if not self._powered or self._state is None:
            return
        self._brake_nms_rad = None
        goal = self._goal
        goal[0], goal[1], goal[2] = command.q_rad, command.dq_rad_s, command.tau_ff_nm
        goal[3:] = 0.0
        if command.mode is CommandMode.IMPEDANCE:
            goal[3], goal[4] = command.stiffness_nm_rad, command.damping_nms_rad
        self._send(bus, self._state)

    def enable(self) -> None:
        """Power the motors.

        Raises:
            Refused: The device is not open or unreachable.
        """
        self._order("power", lambda bus: bus.send_power(True))
        self._powered = True
        self._brake_nms_rad = None

    def brake(self, damping_nms_rad: float) -> None:
        """Resist motion by damping only, from now on with every reading.

        Raises:
            OSError: The device is not open or unreachable.
        """
        bus = self._opened()
        self._brake_nms_rad = damping_nms_rad
        if self._powered and self._state is not None:
            self._push(bus, self._state, damping_nms_rad)

    def power_off(self) -> None:
        """Cut motor power; said again with the readings that follow, in case the driver was restarted.

        Raises:
            OSError: The device is unreachable.
        """
        was_powered, self._powered = self._powered, False
        self._brake_nms_rad = None
        bus = self._bus
        if bus is None:
            return
        bus.send_power(False)
        if was_powered and self.device.command == "effort":
            bus.send_efforts(self._zeros.tolist())

    def clear_faults(self) -> None:
        """Ask the driver to clear its faults; those that last are reported again.

        Raises:
            Refused: The device is not open or unreachable.
        """
        self._order("clear", lambda bus: bus.send_clear())
        self._faults = ()

    def close(self) -> None:
        """Cut power, leave the network, give the device back; one out of reach is left to its watchdog."""
        with suppress(OSError):
            self.power_off()
        if self._bus is not None:
            self._bus.close()
        self._bus = None
        if self._lease is not None:
            self._lease.release()
        self._lease = None

    def _opened(self) -> Bus:
        if self._bus is None:
            raise OSError(errno.ENOTCONN, "not open")
        return self._bus

    def _order(self, what: str, order: Callable[[Bus], None]) -> None:
        """What a person asks for: a device that cannot be told so refuses."""
        try:
            order(self._opened())
        except OSError as error:
            thing, value = f"device {self.capabilities.name}", error.strerror or "unreachable"
            raise Refused(thing, value, f"reachable for {what}", "check its connection") from error

    def _push(self, bus: Bus, state: DeviceState, damping_nms_rad: float) -> None:
        """Send damping only; a driver without a known spring is told to stay where it is."""
        goal = self._goal
        goal[0], goal[1:4], goal[4] = state.q_rad, 0.0, damping_nms_rad
        self._send(bus, state)

    def _send(self, bus: Bus, state: DeviceState) -> None:
        """Send the goal as the driver takes it."""
        if not impedance_torque(self._goal, state.q_rad, state.dq_rad_s, self._cap_nm, self._torque_nm):
            raise OSError(errno.EDOM, "commanded something that is no number")
        if self.device.command == "effort":
            bus.send_efforts(self._map.efforts(self._torque_nm))
        elif self._servo_nm_rad is not None:
            meant_rad = state.q_rad + self._torque_nm / self._servo_nm_rad
            bus.send_point(self._map.positions(meant_rad), self._map.velocities(self._zeros))
        else:
            bus.send_point(self._map.positions(self._goal[0]), self._map.velocities(self._goal[1]))

    def _find(self, bus: Bus) -> None:
        """Wait for the first joint state and for a listener, then see who else is there."""
        name = self.capabilities.name
        self._state = None
        end_ns = time.monotonic_ns() + round(ANSWER_S * 1e9)
        message = bus.take_state()
        while message is None or not bus.heard():
            if time.monotonic_ns() > end_ns:
                what = "silent" if message is None else "deaf: it listens to neither command nor power"
                remedy = "switch it on, start its driver, and compare its topics with its device file"
                raise Refused(f"device {name}", f"{what} for {ANSWER_S:g} s", "answering", remedy)
            time.sleep(_LOOK_S)
            message = bus.take_state() or message
        absent = self._map.missing(message)
        if absent:
            value, bound = f"without {absent[0]}", "as its device file says (" + ", ".join(message.name) + ")"
            raise Refused(
                f"joint state of {name}", value, bound, "correct the joint names in the device file"
            )
        time.sleep(SETTLE_S)
        if bus.rivals():
            bound = "commanded by this app alone"
            raise Refused(f"device {name}", "commanded by somebody else", bound, "stop the other program")
        bus.send_power(False)
        self._state = self._map.state(bus.take_state() or message, self._now_ns(), 0, ())
