"""A robot that forgets keeps the simulated slacking patient working; one that does not takes over."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from robot_iface.types import Plan


def test_more_effort_is_left_with_forgetting_than_without(
    make_plan: Callable[..., Plan], fist: Any, course: Any
) -> None:
    """On the shipped assistive law, which needs some repetitions to learn what the patient no longer does."""
    final: dict[float, float] = {}
    for forgetting in (0.8, 1.0):
        plan = make_plan(
            "slacking",
            "assistive",
            multiple=0.5,
            repetitions=8,
            path=fist(3.0, 35.0, 25.0),
            speed=1.0,
            assist_forgetting=forgetting,
        )
        run = course(plan)
        assert run.end.completed
        final[forgetting] = run.robot.patient.willingness
    assert final[1.0] * 1.02 < final[0.8] < 0.5, "and all slack, as they do where a robot helps"
