"""Pinch, tripod and lateral grips: they touch, oppose, and refuse what they cannot."""

from __future__ import annotations

import math

import pytest

from rehab_app.errors import Refused
from rehab_app.grasp.hand import parse_hand, robot_hand
from rehab_app.grasp.objects import Sphere
from rehab_app.grasp.precision import find_precision
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD
from sessions.records import JOINTS


@pytest.mark.parametrize(("grip", "digits"), [("pinch", 2), ("tripod", 3), ("lateral", 2)])
def test_the_pads_touch_and_oppose_inside_every_range(grip: str, digits: int) -> None:
    held = find_precision(parse_hand("human:length=0.18"), Sphere(0.025), grip)
    assert len(held.gap_m) == digits
    assert max(abs(gap) for gap in held.gap_m.values()) <= 5e-4
    assert held.opposition_rad < math.radians(30)
    for name, angle in held.angles_rad.items():
        row = JOINTS.index(name)
        assert JOINT_MIN_RAD[row] <= angle <= JOINT_MAX_RAD[row]
    left = find_precision(parse_hand("human:length=0.18", "left"), Sphere(0.025), grip)
    for name, angle in held.angles_rad.items():
        assert left.angles_rad[name] == pytest.approx(angle, abs=1e-4)


def test_a_thing_too_big_or_a_hand_that_cannot_is_refused() -> None:
    with pytest.raises(Refused, match="choose another size"):
        find_precision(parse_hand("human"), Sphere(0.12), "pinch")
    with pytest.raises(Refused, match="--hand human"):
        find_precision(robot_hand(), Sphere(0.02), "tripod")
