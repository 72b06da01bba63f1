"""Hazard 11: fatigue raises tone and pain. A fall in what is reached brings a rest, and then the end."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Advance, Order, Rig, ScriptedInbox, Surroundings, perform
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, VirtualPatient, device_capabilities
from robot_iface.sim.kinds import virtual_patient
from robot_iface.types import (
    Mode,
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    ReferencePath,
    RunEnd,
    SafetyEvent,
    SafetyState,
)

TIRES = VirtualPatient(0.040, ability=0.7, will="follow", tires_j=0.05)


class NeverPressed:
    def pressed(self) -> bool:
        return False


def run(
    patient: VirtualPatient, mode: Mode, repetitions: int, orders: tuple[tuple[float, Order], ...] = ()
) -> tuple[RunEnd, list[PhaseChange], list[SafetyEvent]]:
    t_s = np.linspace(0.0, 1.5, 46)
    closing = 0.5 - 0.5 * np.cos(2.0 * np.pi * t_s / 1.5)
    q = np.deg2rad(10.0 + 15.0 * closing[:, None] * np.ones(12))
    path = ReferencePath(DRIVEN, t_s, q, "0" * 64, "right")
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad)
    plan = Plan(
        "exoskeleton",
        path,
        Prescription(mode, repetitions=repetitions, cue_timeout_s=1.0, rest_s=0.1, hold_s=0.1),
        limits,
        PatientTwin(),
        3,
        "0",
    )
    robot = SimulatedExoskeleton(plan.twin, plan.seed, (), patient)
    clock = SimulatedClock(robot.capabilities.period_ns, robot.advance)
    heard: list[object] = []
    around = Surroundings(NeverPressed(), heard.append, ScriptedInbox(orders))
    end = perform(plan, Rig(robot, clock, robot.patient), around)
    phases = [item for item in heard if isinstance(item, PhaseChange)]
    return end, phases, [item for item in heard if isinstance(item, SafetyEvent)]


def test_a_tiring_patient_is_given_a_rest_once_and_then_the_run_ends() -> None:
    end, phases, events = run(TIRES, "resistive", 30)
    assert end.reason == "fatigue"
    assert not end.completed
    assert end.state in (SafetyState.READY, SafetyState.OFF), "it ends as a run does, not by a stop"
    assert [event.cause for event in events] == ["fatigue", "fatigue"]
    rest = [phase.t_ns for phase in phases if phase.phase == "rest-proposed"]
    assert 59.5 < (rest[-1] - rest[0]) * 1e-9 <= 60.0
    assert max(phase.repetition for phase in phases) < 29


def test_the_proposed_rest_may_be_declined() -> None:
    """One order to go on every second: some are refused, one of them ends the rest."""
    orders = tuple((float(second), Advance()) for second in range(30, 200))
    _, phases, events = run(TIRES, "resistive", 12, orders)
    rest = [phase.t_ns for phase in phases if phase.phase == "rest-proposed"]
    assert rest, [event.cause for event in events]
    assert (rest[-1] - rest[0]) * 1e-9 < 1.1


def test_who_does_not_tire_is_not_sent_to_rest_nor_is_a_passive_hand() -> None:
    fresh = VirtualPatient(0.040, ability=0.7, will="follow")
    for mode, patient in (("resistive", fresh), ("passive", TIRES)):
        end, _, events = run(patient, mode, 10)
        assert end.reason == "repetitions"
        assert not events


@pytest.mark.parametrize(("ability", "tires_j"), [(0.7, 0.07), (0.9, 0.15), (0.5, 0.2)])
def test_help_does_not_hide_a_patient_who_tires(ability: float, tires_j: float) -> None:
    """The robot goes on to reach the target; the hand leads it less and less, and then fails."""
    tires = VirtualPatient(0.045, ability=ability, will="follow", tires_j=tires_j)
    end, _, events = run(tires, "assistive", 40)
    assert end.reason == "fatigue"
    assert [event.cause for event in events] == ["fatigue", "fatigue"]


@pytest.mark.parametrize("kind", ["healthy", "weak", "mas1+", "mas2", "contracture", "flaccid"])
def test_help_that_is_taken_back_is_no_fatigue(kind: str) -> None:
    end, _, events = run(virtual_patient(kind), "assistive", 25)
    assert end.reason == "repetitions"
    assert "fatigue" not in [event.cause for event in events]
