"""A run that an error cuts short: the hand is braked before it loses power."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Rig, ScriptedInbox, Surroundings, perform
from robot_iface.sim import SimulatedExoskeleton
from robot_iface.types import Plan, SafetyState, TickBlock

MakePlan = Callable[..., Plan]


class NeverPressed:
    def pressed(self) -> bool:
        return False


class Watched(SimulatedExoskeleton):
    """The simulated exoskeleton, which notes what is done to its power and how fast the hand then moves."""

    def __init__(self, plan: Plan) -> None:
        self.log: list[str] = []
        self.speeds_rad_s: list[float] = []
        super().__init__(plan.twin, plan.seed)

    def brake(self, damping_nms_rad: float) -> None:
        self.log.append("brake")
        super().brake(damping_nms_rad)

    def power_off(self) -> None:
        self.log.append("power off")
        super().power_off()

    def advance(self, t_ns: int | None = None) -> None:
        super().advance(t_ns)
        if "brake" in self.log:
            self.speeds_rad_s.append(float(np.abs(self.hand_speed_rad_s).max()))


def test_a_listener_that_fails_leaves_a_braked_hand_not_a_snapping_one(
    make_plan: MakePlan, fist: Any
) -> None:
    """A stiff hand is held open, and the disk is full."""
    plan = make_plan("mas2", path=fist(3.0, 25.0, 30.0))
    robot = Watched(plan)

    def record(message: Any) -> None:
        if isinstance(message, TickBlock) and message.path_s[-1] > 1.5:
            raise OSError("no space left")

    clock = SimulatedClock(robot.capabilities.period_ns, robot.advance)
    with pytest.raises(OSError, match="no space left"):
        perform(plan, Rig(robot, clock, robot.patient), Surroundings(NeverPressed(), record, ScriptedInbox()))
    assert robot.log[:3] == ["power off", "brake", "power off"], "opened without power, braked, then cut"
    assert 100 < len(robot.speeds_rad_s) <= 5002
    assert robot.speeds_rad_s[-1] < np.deg2rad(6.0)


def test_the_ramp_of_the_prescription_is_the_ramp_of_the_supervisor(make_plan: MakePlan, course: Any) -> None:
    for ramp_s in (1.0, 2.0):
        plan = make_plan()
        run = course(replace(plan, prescription=replace(plan.prescription, ramp_s=ramp_s)))
        ramping = run.column("safety_state") == int(SafetyState.RAMP_IN)
        assert ramping.sum() == pytest.approx(1000 * ramp_s, abs=3)
