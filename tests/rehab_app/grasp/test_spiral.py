"""The way to a posture: ends where it should, runs one way, stays inside the limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rehab_app.errors import Refused
from rehab_app.grasp.hand import parse_hand
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import try_posture
from rehab_app.grasp.spiral import inverse, spiral_path, tip_m
from robot_iface.kinematics.dlr_hit import finger_inverse
from sessions.records import JOINTS


@pytest.mark.parametrize("name", ["dlr-hit-ii", "human:length=0.18"])
@pytest.mark.parametrize(
    ("method", "radius_m"), [("thesis", 0.0225), ("contact", 0.0225), ("contact", 0.028)]
)
def test_the_path_ends_in_the_posture_and_runs_one_way(name: str, method: str, radius_m: float) -> None:
    posture = try_posture(parse_hand(name), Cylinder(radius_m), "transverse", method, None)
    way = spiral_path(posture)
    assert not way.warnings
    assert way.start_pip_rad >= math.radians(22.0) - 1e-9
    for joint, angle in posture.angles_rad.items():
        assert way.joints_rad[-1, JOINTS.index(joint)] == pytest.approx(angle, abs=1e-12)
    fingers = [
        JOINTS.index(f"{finger}_{joint}")
        for finger in ("index", "little")
        for joint in ("mcp_flexion", "pip")
    ]
    assert (np.diff(way.joints_rad[:, fingers], axis=0) >= -1e-9).all()
    mcp = way.joints_rad[:, [JOINTS.index(f"{f}_mcp_flexion") for f in ("index", "middle", "ring", "little")]]
    pip = way.joints_rad[:, [JOINTS.index(f"{f}_pip") for f in ("index", "middle", "ring", "little")]]
    assert np.abs(tip_m(posture.hand, mcp, pip) - way.tips_m).max() < 1e-9
    assert mcp.min() >= posture.hand.mcp_min_rad
    assert max(mcp.max() - posture.hand.mcp_max_rad, pip.max() - posture.hand.pip_max_rad) <= 0


def test_the_tips_lie_on_logarithmic_spirals() -> None:
    way = spiral_path(try_posture(parse_hand("dlr-hit-ii"), Cylinder(0.0225), "transverse", "thesis", None))
    radius, angle = np.linalg.norm(way.tips_m, axis=2), np.arctan2(way.tips_m[..., 1], way.tips_m[..., 0])
    angle = np.unwrap(angle, axis=0)
    assert np.log(radius / radius[0]) == pytest.approx(way.pitch * (angle - angle[0]), abs=1e-12)


def test_two_inverses_agree_for_the_robot() -> None:
    hand = parse_hand("dlr-hit-ii")
    rng = np.random.default_rng(71)
    mcp, pip = rng.uniform(0.0, hand.mcp_max_rad, (200, 4)), rng.uniform(0.05, hand.pip_max_rad, (200, 4))
    tips = tip_m(hand, mcp, pip)
    found = inverse(hand, tips)
    assert np.abs(found[0] - mcp).max() < 1e-9
    assert np.abs(found[1] - pip).max() < 1e-9
    closed = finger_inverse(np.stack([tips[..., 0], np.zeros((200, 4)), -tips[..., 1]], axis=-1))
    assert np.abs(closed[..., 2] - found[1]).max() < 1e-7


def test_a_straight_start_and_points_out_of_reach_are_refused() -> None:
    posture = try_posture(parse_hand("dlr-hit-ii"), Cylinder(0.0225), "transverse", "thesis", None)
    with pytest.raises(Refused, match=r"0\.384"):
        spiral_path(posture, start_pip_rad=0.0)
    for point in (np.full((4, 2), 0.2), np.full((4, 2), np.nan), np.zeros((4, 2))):
        with pytest.raises(Refused, match="distance from its knuckle"):
            inverse(posture.hand, point)
