"""One control tick without physics, beside the same duties written down in plain numpy."""

from __future__ import annotations

import gc
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from robot_iface.loop import SimulatedClock
from robot_iface.runtime import PresentPatient, Rig, ScriptedInbox, Surroundings, perform
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import Capabilities, DeviceCommand, DeviceState, Mode, Plan
from tests.bench.motion.numpy_tick import NumpyTick

PERIOD_NS = 1_000_000
_TURNS = 3


class FollowingHand:
    """A device that is always exactly where it was told to be: it costs one state a tick and nothing else."""

    def __init__(self, start_rad: np.ndarray) -> None:
        self._zeros = np.zeros(len(DRIVEN))
        self._q, self._dq = start_rad, self._zeros
        self._tick = 0
        self.stamps_ns: list[int] = []

    @property
    def capabilities(self) -> Capabilities:
        return device_capabilities()

    def open(self) -> None: ...

    def read(self) -> DeviceState:
        zeros = self._zeros
        return DeviceState(
            self._tick * PERIOD_NS, self._tick, self._q, self._q, self._dq, zeros, zeros, 30.0, ()
        )

    def write(self, command: DeviceCommand) -> None:
        self._q, self._dq = command.q_rad, command.dq_rad_s

    def enable(self) -> None: ...

    def brake(self, damping_nms_rad: float) -> None:
        self._dq = self._zeros

    def power_off(self) -> None:
        self._dq = self._zeros

    def clear_faults(self) -> None: ...

    def close(self) -> None: ...

    def advance(self) -> None:
        self._tick += 1
        self.stamps_ns.append(time.perf_counter_ns())


class NeverPressed:
    def pressed(self) -> bool:
        return False


@dataclass(frozen=True, slots=True)
class TickRow:
    """Median cost of a tick, us: ours, of all phases of a run; the peer's, along the path."""

    mode: Mode
    ours_us: float
    numpy_us: float

    @property
    def ratio(self) -> float:
        """Ours over numpy's."""
        return self.ours_us / self.numpy_us


@contextmanager
def uncollected() -> Generator[None]:
    """The garbage collector waits outside: it would strike whoever happens to be running."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def our_tick_us(plan: Plan) -> float:
    """Median cost of a tick of the product: orders, read, task, law, supervisor, write, record; us."""
    assert plan.path is not None
    hand = FollowingHand(plan.path.q_rad[0])
    rig = Rig(hand, SimulatedClock(PERIOD_NS, hand.advance), PresentPatient())
    with uncollected():
        end = perform(plan, rig, Surroundings(NeverPressed(), lambda message: None, ScriptedInbox()))
    assert end.completed, end
    return float(np.median(np.diff(hand.stamps_ns))) / 1e3


def numpy_tick_us(plan: Plan) -> float:
    """Median cost of the same duties in plain numpy, once along the path; us."""
    assert plan.path is not None
    tick = NumpyTick(plan, PERIOD_NS * 1e-9, assistive=plan.prescription.mode == "assistive")
    q, dq = plan.path.q_rad[0].copy(), np.zeros(len(DRIVEN))
    still = np.zeros(len(DRIVEN))
    ticks = round(plan.path.t_s[-1] / plan.prescription.speed / (PERIOD_NS * 1e-9)) - 50
    spent = np.empty(ticks, dtype=np.int64)
    with uncollected():
        for count in range(ticks):
            begun = time.perf_counter_ns()
            q, dq = tick.step(count * PERIOD_NS, q, q, dq, still, still)
            spent[count] = time.perf_counter_ns() - begun
    return float(np.median(spent)) / 1e3


def tick_row(plan: Plan) -> TickRow:
    """Both, taken in turns so that a busy machine is busy for both; the best of three each."""
    turns = [(our_tick_us(plan), numpy_tick_us(plan)) for _ in range(_TURNS)]
    return TickRow(plan.prescription.mode, min(one for one, _ in turns), min(one for _, one in turns))
