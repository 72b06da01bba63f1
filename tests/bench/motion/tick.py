"""One control tick without physics, beside the same tick written down in plain numpy."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from robot_iface.loop import SimulatedClock
from robot_iface.motion import QuinticPath
from robot_iface.runtime import PresentPatient, Rig, ScriptedInbox, Surroundings, perform
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import Capabilities, DeviceCommand, DeviceState, Mode, Plan

PERIOD_NS = 1_000_000


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


def our_tick_us(plan: Plan) -> float:
    """Median cost of a tick of the product: orders, read, task, law, supervisor, write, record; us."""
    assert plan.path is not None
    hand = FollowingHand(plan.path.q_rad[0])
    rig = Rig(hand, SimulatedClock(PERIOD_NS, hand.advance), PresentPatient())
    end = perform(plan, rig, Surroundings(NeverPressed(), lambda message: None, ScriptedInbox()))
    assert end.completed, end
    return float(np.median(np.diff(hand.stamps_ns))) / 1e3


@dataclass(frozen=True, slots=True)
class _Learnt:
    torque_nm: np.ndarray
    step_s: float


def numpy_tick_us(plan: Plan, ticks: int = 20_000) -> float:
    """Median cost of the same duties in plain numpy: path, law, feed-forward, checks, record; us."""
    assert plan.path is not None
    path, limits = QuinticPath(plan.path), plan.limits
    learnt = _Learnt(np.zeros((round(path.duration_s / 0.01) + 2, len(DRIVEN))), 0.01)
    coefficients = path.sample(np.linspace(0.0, path.duration_s, 400))
    stiffness, damping = np.full(len(DRIVEN), 0.9), np.full(len(DRIVEN), 0.035)
    record = np.empty((50, 12, len(DRIVEN)))
    previous = np.zeros(len(DRIVEN))
    q = coefficients[0].copy()
    dq = np.zeros(len(DRIVEN))
    spent = np.empty(ticks, dtype=np.int64)
    for tick in range(ticks):
        begun = time.perf_counter_ns()
        share = (tick * 1e-3 % path.duration_s) / path.duration_s * 398
        low = int(share)
        part = share - low
        wanted = coefficients[low] * (1.0 - part) + coefficients[low + 1] * part
        speed = (coefficients[low + 1] - coefficients[low]) / (path.duration_s / 400)
        place = int(tick * 1e-3 % path.duration_s / learnt.step_s)
        forward = learnt.torque_nm[place]
        error = np.clip(wanted - q, -0.25, 0.25)
        tau = stiffness * error + damping * (speed - dq) + forward
        tau = np.clip(tau, -limits.tau_interaction_nm, limits.tau_interaction_nm)
        fine = (
            np.isfinite(q).all()
            and np.isfinite(tau).all()
            and (q >= limits.q_min_rad - limits.margin_rad).all()
            and (q <= limits.q_max_rad + limits.margin_rad).all()
            and (np.abs(dq) <= limits.trip_speed_rad_s).all()
            and (np.abs(tau - previous) <= 1.0).all()
            and (np.abs(tau * dq) <= limits.power_w).all()
        )
        assert fine
        rows = (q, dq, tau, forward, wanted, speed, stiffness, damping, error, tau, tau, tau)
        for column, row in enumerate(rows):
            record[tick % 50, column] = row
        previous = tau
        spent[tick] = time.perf_counter_ns() - begun
    return float(np.median(spent)) / 1e3


def tick_rows(plans: dict[Mode, Plan]) -> list[tuple[str, float, float]]:
    """Mode, our tick and numpy's, us, taken in turns so that a busy machine is busy for both."""
    rows: list[tuple[str, float, float]] = []
    for mode, plan in plans.items():
        ours = [our_tick_us(plan) for _ in range(3)]
        numpys = [numpy_tick_us(plan) for _ in range(3)]
        rows.append((mode, min(ours), min(numpys)))
    return rows
