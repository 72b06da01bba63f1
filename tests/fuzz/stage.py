"""What a run is given in an episode: a device with a spy in it, a bad clock, a silent app, and the stop."""

from __future__ import annotations

import dataclasses
from collections import deque
from typing import Any

from robot_iface.loop import SimulatedClock
from robot_iface.ports import HandRobot
from robot_iface.runtime import LiveSample, Order, Pain, Reset
from robot_iface.types import Capabilities, DeviceCommand, DeviceState, Limits
from tests.fuzz.script import Script, Trouble

PERIOD_NS = 1_000_000


class Time:
    """Ticks of the episode, and the troubles that are there now."""

    def __init__(self, script: Script) -> None:
        self.tick = 0
        self._troubles = script.troubles

    def active(self, kind: str) -> Trouble | None:
        for trouble in self._troubles:
            if trouble.kind == kind and trouble.active(self.tick):
                return trouble
        return None


class BadClock(SimulatedClock):
    """Simulated time that jumps, stands still and is missed; ``robot`` keeps its own time but in a stall."""

    def __init__(self, robot: Any, time: Time) -> None:
        super().__init__(PERIOD_NS, lambda: None)
        self._robot, self._time, self._offset_ns, self._missed = robot, time, 0, 0
        self._shift_ns = 0

    def wait_next_tick(self) -> int:
        time = self._time
        time.tick += 1
        for kind, sign in (("clock-forward", 1), ("clock-backward", -1), ("stall", 1)):
            trouble = time.active(kind)
            if trouble is not None and trouble.start == time.tick:
                jump_ns = sign * round(trouble.size * 200.0) * PERIOD_NS
                self._offset_ns += jump_ns
                self._shift_ns += jump_ns if kind == "stall" else 0
        super().wait_next_tick()
        self._robot.advance(super().now_ns() + self._shift_ns)
        self._missed = self._missed + 1 if time.active("overruns") else 0
        return 0

    def now_ns(self) -> int:
        return super().now_ns() + self._offset_ns

    @property
    def overruns_in_row(self) -> int:
        return self._missed


class SilentApp:
    """Signs of life that cease. Implements ``Monitor``."""

    def __init__(self, time: Time) -> None:
        self._time = time

    def _age(self, kind: str) -> int:
        trouble = self._time.active(kind)
        return 0 if trouble is None else (self._time.tick - trouble.start) * PERIOD_NS

    def heartbeat_age_ns(self) -> int:
        return self._age("app-frozen")

    def operator_age_ns(self) -> int:
        return self._age("operator-gone")

    def publish(self, sample: LiveSample) -> None: ...

    def latched(self) -> None: ...


class Button:
    """The stop, pressed for a while by the script, and for good at the episode's end."""

    def __init__(self, time: Time, end_s: float) -> None:
        self._time, self._end = time, round(end_s * 1e3)

    def pressed(self) -> bool:
        return self._time.tick >= self._end or self._time.active("stop") is not None


class People:
    """Orders at their times. Implements ``Inbox``; notes what a run has taken."""

    def __init__(self, script: Script, time: Time) -> None:
        self._orders, self._time = deque(script.orders), time
        self.pain = self.reset = False

    def take(self, t_ns: int) -> Order | None:
        del t_ns  # the loop's clock may be wrong
        if not self._orders or self._time.tick < self._orders[0][0] * 1e3:
            return None
        order = self._orders.popleft()[1]
        self.pain = self.pain or isinstance(order, Pain)
        self.reset = self.reset or isinstance(order, Reset)
        return order


class SpiedRobot:
    """Passes everything on to a device and notes it; its line fails where the script says so."""

    def __init__(self, robot: HandRobot, time: Time, limits: Limits) -> None:
        self._robot, self._time, self._limits = robot, time, limits
        self.mode = "off"
        self.reading: DeviceState | None = None
        self.written: list[DeviceCommand] = []
        self.read_failed = self.write_failed = self.closed = False

    @property
    def capabilities(self) -> Capabilities:
        return self._robot.capabilities

    def open(self) -> None:
        self._fail("open-error")
        self._robot.open()

    def read(self) -> DeviceState:
        self.read_failed = True
        self.reading = self._loaded(self._robot.read())
        self.read_failed = False
        return self.reading

    def _loaded(self, state: DeviceState) -> DeviceState:
        """The reading of a hand that presses against one joint, by 1.05 to 1.45 times its limit."""
        trouble = self._time.active("load")
        if trouble is None:
            return state
        torque = state.tau_interaction_nm.copy()
        joint = round(1e3 * trouble.size) % torque.size
        torque[joint] = (1.05 + 0.4 * trouble.size) * trouble.sign * self._limits.tau_interaction_nm[joint]
        return dataclasses.replace(state, tau_interaction_nm=torque)

    def write(self, command: DeviceCommand) -> None:
        self.written.append(command)
        try:
            self._robot.write(command)
        except OSError:
            self.write_failed = True
            raise
        self.mode = "command"

    def enable(self) -> None:
        self._fail("enable-error")
        self._robot.enable()
        self.mode = "enabled"

    def brake(self, damping_nms_rad: float) -> None:
        self._fail("brake-error")
        self._robot.brake(damping_nms_rad)
        self.mode = "brake"

    def power_off(self) -> None:
        """A line that fails here has lost the device: its own watchdog cuts power."""
        self._robot.power_off()
        self.mode = "off"
        self._fail("power-error")

    def clear_faults(self) -> None:
        self._fail("clear-error")
        self._robot.clear_faults()

    def close(self) -> None:
        self._robot.close()
        self.closed = True
        self._fail("close-error")

    def _fail(self, kind: str) -> None:
        if self._time.active(kind):
            raise OSError(5, "Input/output error")
