"""Hazard: unstable gains shake the hand. They are refused before anything moves."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from robot_iface.control import make_law
from robot_iface.errors import Refused
from robot_iface.sim import device_capabilities
from robot_iface.types import Plan
from tests.robot_iface.conftest import make_plan


@pytest.mark.parametrize(
    ("multiple", "space", "period_ns", "said"),
    [
        (9.0, "fingertip", 1_000_000, r"fingertip stiffness is 900 N/m.*100 to 800 N/m"),
        (
            10.0,
            "joint",
            5_000_000,
            r"damping of thumb_cmc_flexion is .* Nms/rad.*below 0.042 Nms/rad at 5 ms",
        ),
    ],
)
def test_gains_that_would_shake_the_hand_are_refused(
    multiple: float, space: Any, period_ns: int, said: str
) -> None:
    plan: Plan = make_plan(multiple=multiple)
    plan = replace(plan, prescription=replace(plan.prescription, space=space))
    with pytest.raises(Refused, match=said):
        make_law(plan, replace(device_capabilities(), period_ns=period_ns))
