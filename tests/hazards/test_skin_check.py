"""Hazard 9: insensate skin gets sore. After so much motion the clock blocks until a person has looked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot_iface.build import open_rig
from robot_iface.runtime import Order, Resume, ScriptedInbox, Surroundings, perform
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import (
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    ReferencePath,
    RunEnd,
    SafetyEvent,
    TickBlock,
)

CHECK_S = 3.0


class NeverPressed:
    def pressed(self) -> bool:
        return False


def run(orders: tuple[tuple[float, Order], ...]) -> tuple[RunEnd, list[object]]:
    t_s = np.linspace(0.0, 1.0, 31)
    closing = 0.5 - 0.5 * np.cos(2.0 * np.pi * t_s)
    q = np.deg2rad(20.0 + 5.0 * closing[:, None] * np.ones(12))
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad, halved=True)
    ordered = Prescription("passive", repetitions=3, skin_check_s=CHECK_S)
    path = ReferencePath(DRIVEN, t_s, q, "0" * 64, "right")
    plan = Plan("exoskeleton", path, ordered, limits, PatientTwin("flaccid"), 1, "0")
    heard: list[object] = []
    end = perform(plan, open_rig(plan), Surroundings(NeverPressed(), heard.append, ScriptedInbox(orders)))
    return end, heard


def test_the_clock_blocks_until_a_person_has_looked_at_the_skin() -> None:
    end, heard = run(((15.0, Resume()), (30.0, Resume())))
    assert end.completed
    waits = [message for message in heard if isinstance(message, PhaseChange)]
    waits = [phase for phase in waits if phase.phase == "skin-check"]
    assert [e.cause for e in heard if isinstance(e, SafetyEvent)] == ["skin-check", "skin-check"]
    first, last = waits[0].t_ns * 1e-9, max(w.t_ns for w in waits if w.t_ns < 15.5e9) * 1e-9
    assert CHECK_S < first < CHECK_S + 8.0
    assert last > 14.0
    blocks = [message for message in heard if isinstance(message, TickBlock)]
    t_s = np.concatenate([block.t_ns for block in blocks]) * 1e-9
    waiting = (t_s > first + 1.0) & (t_s < 15.0)
    assert not np.concatenate([block.dq_command_rad_s for block in blocks])[waiting].any()
    stiffness = np.concatenate([block.stiffness_nm_rad for block in blocks])[waiting]
    assert stiffness.max() < 0.13, "it rests, it does not hold"


def test_nobody_looks_so_the_run_ends() -> None:
    end, heard = run(())
    assert end.reason == "skin-check"
    assert not end.completed
    assert 300.0 < end.simulated_s < 330.0
    assert max(message.repetition for message in heard if isinstance(message, PhaseChange)) == 0


def test_without_an_order_for_it_there_is_none() -> None:
    assert replace(Prescription("passive"), repetitions=2).skin_check_s == 0.0
