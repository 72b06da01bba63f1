"""What the suites of the motion core share: a movement, plans for it, and simulated runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Order, Rig, ScriptedInbox, Surroundings, perform
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, Fault, SimulatedExoskeleton, VirtualPatient, device_capabilities
from robot_iface.types import (
    Float64,
    Mode,
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    ReferencePath,
    RunEnd,
    SafetyEvent,
    Side,
    TickBlock,
    VirtualKind,
)


class NeverPressed:
    def pressed(self) -> bool:
        return False


def fist(
    duration_s: float = 2.0, depth_deg: float = 22.0, start_deg: float = 8.0, back: bool = True
) -> ReferencePath:
    """All fingers close by ``depth_deg`` along a minimum-jerk profile and, if ``back``, open again."""
    t_s = np.linspace(0.0, duration_s, round(duration_s * 30) + 1)
    u = t_s / duration_s * (2.0 if back else 1.0)
    u = np.where(u > 1.0, 2.0 - u, u)
    closing = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    depth = np.array([0.5 if name.startswith("thumb") else 1.0 for name in DRIVEN]) * depth_deg
    return ReferencePath(DRIVEN, t_s, np.deg2rad(start_deg + closing[:, None] * depth), "0" * 64, "right")


def make_plan(
    kind: VirtualKind = "healthy",
    mode: Mode = "passive",
    *,
    multiple: float = 3.0,
    repetitions: int = 1,
    speed: float = 0.5,
    path: ReferencePath | None = None,
    seed: int = 1,
    side: Side = "right",
    realtime: bool = False,
    stop_at_s: tuple[float, ...] = (),
    rest_s: float = 0.2,
    hold_s: float = 0.2,
    **ordered: Any,
) -> Plan:
    """A plan within the shipped limits; ``ordered`` are further fields of the prescription."""
    device = device_capabilities()
    return Plan(
        device="exoskeleton",
        path=path or fist(),
        prescription=Prescription(
            mode, speed, repetitions, multiple, rest_s=rest_s, hold_s=hold_s, **ordered
        ),
        limits=shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad, spastic=kind.startswith("mas")),
        twin=PatientTwin(kind, side),
        seed=seed,
        software_version="0.0",
        realtime=realtime,
        stop_at_s=stop_at_s,
    )


class Course:
    """Everything that one simulated run said."""

    def __init__(
        self,
        plan: Plan,
        orders: tuple[tuple[float, Order], ...] = (),
        faults: tuple[Fault, ...] = (),
        patient: VirtualPatient | None = None,
    ) -> None:
        self.robot = SimulatedExoskeleton(plan.twin, plan.seed, faults, patient)
        clock = SimulatedClock(self.robot.capabilities.period_ns, self.robot.advance)
        self.messages: list[PhaseChange | SafetyEvent | TickBlock | RunEnd] = []
        around = Surroundings(NeverPressed(), self.messages.append, ScriptedInbox(orders))
        self.end = perform(plan, Rig(self.robot, clock, self.robot.patient), around)
        self.phases = [message for message in self.messages if isinstance(message, PhaseChange)]
        self.events = [message for message in self.messages if isinstance(message, SafetyEvent)]
        self._blocks = [message for message in self.messages if isinstance(message, TickBlock)]

    def column(self, name: str) -> Float64:
        return np.concatenate([getattr(block, name) for block in self._blocks])

    def sequence(self) -> list[str]:
        """Phases in order, without repeats."""
        names = [phase.phase for phase in self.phases]
        return [name for index, name in enumerate(names) if index == 0 or names[index - 1] != name]

    def moving(self, repetition: int) -> Float64:
        """Which ticks belong to a repetition's movement."""
        starts = np.array([phase.t_ns for phase in self.phases])
        place = np.searchsorted(starts, self.column("t_ns"), side="right") - 1
        wanted = [phase.phase == "move" and phase.repetition == repetition for phase in self.phases]
        return np.array(wanted)[place]

    def rmse_deg(self, repetition: int) -> float:
        error = self.column("q_rad") - self.column("q_reference_rad")
        return float(np.rad2deg(np.sqrt((error[self.moving(repetition)] ** 2).mean())))

    def rms_interaction_nm(self, repetition: int) -> float:
        return float(np.sqrt((self.column("tau_interaction_nm")[self.moving(repetition)] ** 2).mean()))

    def multiple(self, repetition: int) -> float:
        values = [
            phase.stiffness_multiple.mean()
            for phase in self.phases
            if phase.repetition == repetition and phase.phase == "move"
        ]
        return float(np.mean(values[len(values) // 2 :]))

    def started_by(self, repetition: int) -> set[str]:
        return {p.started_by for p in self.phases if p.repetition == repetition and p.phase == "move"}


@pytest.fixture(name="fist")
def fist_fixture() -> Callable[..., ReferencePath]:
    """Makes a path that closes the fingers and, by default, opens them again."""
    return fist


@pytest.fixture(name="make_plan")
def make_plan_fixture() -> Callable[..., Plan]:
    """Makes a plan within the shipped limits."""
    return make_plan


@pytest.fixture(name="course")
def course_fixture() -> type[Course]:
    """Runs a plan on simulated time and keeps what it said."""
    return Course
