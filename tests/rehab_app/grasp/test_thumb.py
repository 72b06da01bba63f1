"""The thumb around an object: people's aperture before anything else, and closed as far as it goes."""

from __future__ import annotations

import numpy as np
import pytest

from rehab_app.grasp import thumb as module
from rehab_app.grasp.closing import in_object_frame
from rehab_app.grasp.hand import GraspHand, human_hand
from rehab_app.grasp.objects import Cylinder, Sphere, Thing
from rehab_app.grasp.posture import Posture, find_posture
from rehab_app.grasp.thumb import APERTURE_RAD, Thumb, close_thumb
from robot_iface.kinematics import JOINT_MAX_RAD, average_hand, forward
from sessions.records import JOINTS

HAND = human_hand(average_hand())
IP = JOINTS.index("thumb_ip")
ROUND = [Cylinder(0.0225), Cylinder(0.0325), Cylinder(0.035), Sphere(0.040)]
"""Where the average thumb reaches."""


@pytest.fixture(scope="module", params=ROUND, ids=lambda thing: f"{type(thing).__name__}-{thing.radius_m}")
def posture(request: pytest.FixtureRequest) -> Posture:
    return find_posture(HAND, request.param)


def closed(posture: Posture) -> Thumb:
    return close_thumb(HAND, posture.thing, posture.z_m, posture.alpha_rad, APERTURE_RAD["transverse"])


def gaps_m(hand: GraspHand, posture: Posture, thing: Thing, angles_rad: dict[str, float]) -> np.ndarray:
    """From the thumb's three links to the object, by the hand's own kinematics."""
    joints = np.zeros(len(JOINTS))
    for name, angle in angles_rad.items():
        joints[JOINTS.index(name)] = angle
    assert hand.person is not None
    points = forward(hand.person, joints).landmarks_m[None, :4]
    placed = in_object_frame(hand, thing, np.array([posture.z_m]), np.array([posture.alpha_rad]), points)[0]
    return thing.distance_m(placed[:-1], placed[1:]) - hand.thumb_half_m


def test_peoples_aperture_is_left_only_where_the_thumb_would_stay_off(
    posture: Posture, monkeypatch: pytest.MonkeyPatch
) -> None:
    rule = APERTURE_RAD["transverse"]
    free = closed(posture)
    monkeypatch.setattr(module, "_OFF_RULE_RAD", np.zeros(1))
    by_rule = closed(posture)
    assert abs(free.aperture_rad - rule) <= np.deg2rad(10.5)
    if by_rule.holds:
        # half a degree is what nearness may take; five are the next that are tried
        assert abs(free.aperture_rad - rule) <= abs(by_rule.aperture_rad - rule) + np.deg2rad(0.5)
        assert free.holds


def test_it_is_closed_as_far_as_it_goes_and_cuts_nothing(posture: Posture) -> None:
    thumb = closed(posture)
    assert thumb.holds
    here = gaps_m(HAND, posture, posture.thing, thumb.angles_rad)
    np.testing.assert_allclose(here, thumb.gap_m, atol=1e-12)
    assert here.min() >= -1e-5
    assert np.abs(here).min() <= 1e-5
    ip, end = thumb.angles_rad["thumb_ip"], float(JOINT_MAX_RAD[IP])
    further = [
        gaps_m(HAND, posture, posture.thing, {**thumb.angles_rad, "thumb_ip": angle})[2]
        for angle in np.linspace(min(ip + 0.01, end), end, 40)
    ]
    assert further[0] < 0 or ip > end - 0.01 or min(further) > 0
