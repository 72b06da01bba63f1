"""Hazard 2: a contracture is taken for weakness. A virtual block must never raise assistance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from robot_iface.control import AssistAsNeeded
from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Rig, ScriptedInbox, Surroundings, perform
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, device_capabilities
from robot_iface.sim.kinds import virtual_patient
from robot_iface.types import DIGITS, PatientTwin, Plan, Prescription, ReferencePath


def open_against(rigid: Any, assist: AssistAsNeeded, block_rad: float | None, weak: bool) -> None:
    """One repetition of opening by 40 degrees at 15 deg/s, against a block or with a weak hand."""
    hand = {"q_rad": 1.0, "rest_rad": 1.0, "stiffness": 0.35 if weak else 0.05}
    rig = rigid.Rig(ramp_s=0.05, **hand)
    rig.go_active()
    speed = np.full(3, np.deg2rad(-15.0))
    for _ in range(2600):
        if block_rad is not None:
            rig.hand.effort = lambda t_s: 30.0 * np.maximum(block_rad - rig.hand.q, 0.0)
        rig.speed, rig.multiple = speed, assist.multiple(speed)
        rig.cycle()
        state = rig.states[-1]
        assist.observe(speed, rig.goal - state.q_rad, state.dq_rad_s, state.tau_interaction_nm)
    assist.finish_repetition()


def test_a_blocked_opening_never_raises_assistance(rigid: Any) -> None:
    assist = AssistAsNeeded(rigid.NAMES, 1.5, rigid.PERIOD_S)
    for _ in range(3):
        before = assist.by_direction()
        open_against(rigid, assist, block_rad=0.85, weak=False)
        assert np.all(assist.by_direction() <= before + 1e-12)


def test_weakness_without_a_block_does_raise_it(rigid: Any) -> None:
    """The same error from a hand that lags but moves is weakness, and is helped."""
    assist = AssistAsNeeded(rigid.NAMES, 0.5, rigid.PERIOD_S)
    open_against(rigid, assist, block_rad=None, weak=True)
    assert assist.by_direction()[0].max() > 0.5


@pytest.mark.parametrize("kind", ["contracture", "mas2", "mas3"])
def test_fingers_that_only_hold_their_place_are_never_helped_more(kind: str) -> None:
    """A stiff hand whose index moves: the others lie far from the posture, which is no weakness."""
    t_s = np.linspace(0.0, 2.0, 61)
    there_and_back = 0.5 - 0.5 * np.cos(np.pi * t_s)
    q = np.deg2rad(8.0 + 2.0 * there_and_back[:, None] * np.ones(len(DRIVEN)))  # as a recorded hand sways
    q[:, DRIVEN.index("index_pip")] += np.deg2rad(30.0) * there_and_back
    assistance = ((1.5,) * 5,) * 2
    path = ReferencePath(DRIVEN, t_s, q, "0" * 64, "right")
    ordered = Prescription("assistive", repetitions=3, cue_timeout_s=1.0, rest_s=0.1, assistance=assistance)
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad)
    plan = Plan("exoskeleton", path, ordered, limits, PatientTwin(kind), 5, "0")
    robot = SimulatedExoskeleton(plan.twin, plan.seed, (), virtual_patient(kind))
    clock = SimulatedClock(robot.capabilities.period_ns, robot.advance)
    around = Surroundings(NeverPressed(), lambda _: None, ScriptedInbox(()))
    end = perform(plan, Rig(robot, clock, robot.patient), around)
    assert end.completed, end.reason
    others = np.delete(np.array(end.assistance), DIGITS.index("index"), axis=1)
    assert np.all(others <= 1.5)


class NeverPressed:
    def pressed(self) -> bool:
        return False
