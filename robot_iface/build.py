"""The only place that chooses device and clock of a run."""

from __future__ import annotations

import time
from collections.abc import Callable

from robot_iface.errors import Refused
from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Rig
from robot_iface.sim import SimulatedExoskeleton, device_capabilities
from robot_iface.types import Capabilities, Plan

DEVICES: tuple[str, ...] = ("exoskeleton",)
"""Devices that this version can move."""
_MOST_BEHIND_NS = 250_000_000


def capabilities(device: str) -> Capabilities:
    """What a device is and can do, known without opening it.

    Raises:
        Refused: There is no such device.
    """
    if device not in DEVICES:
        raise Refused("robot", repr(device), "one of " + ", ".join(DEVICES), "choose one of these")
    return device_capabilities()


def open_rig(plan: Plan) -> Rig:
    """Device, clock and patient for a plan; nothing is opened or powered yet.

    Raises:
        Refused: There is no such device, or no such virtual patient.
    """
    if plan.device not in DEVICES:
        raise Refused("robot", repr(plan.device), "one of " + ", ".join(DEVICES), "choose one of these")
    robot = SimulatedExoskeleton(plan.twin, plan.seed)
    if plan.realtime:
        return Rig(robot, PacedSimulatedClock(robot.capabilities.period_ns, robot.advance), robot.patient)
    return Rig(robot, SimulatedClock(robot.capabilities.period_ns, robot.advance), robot.patient)


class PacedSimulatedClock(SimulatedClock):
    """Simulated time that keeps pace with the wall clock, so that people can watch and act.

    Control and physics still advance one period at a time, so a stalled machine makes the simulation late,
    never different: no tick is skipped, none is an overrun. After a stall it makes up for 250 ms at most; the
    rest is left out of the wall clock's account instead of rushing the patient.

    Args:
        period_ns: Control period.
        advance: Called once a tick to advance the simulated device by one period.
    """

    def __init__(self, period_ns: int, advance: Callable[[], None]) -> None:
        super().__init__(period_ns, advance)
        self._start_ns = time.monotonic_ns()

    def wait_next_tick(self) -> int:
        """Wait until the tick is due by the wall clock, then advance; returns how late it was."""
        ahead_ns = self._start_ns + self.now_ns() + self.period_ns - time.monotonic_ns()
        if ahead_ns > 0:
            time.sleep(ahead_ns * 1e-9)
        elif ahead_ns < -_MOST_BEHIND_NS:
            self._start_ns += -ahead_ns - _MOST_BEHIND_NS
        super().wait_next_tick()
        return max(-ahead_ns, 0)
