"""Contact-aware postures, judged by MuJoCo's own geometry."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from rehab_app.errors import Refused
from rehab_app.grasp.closing import FingerClosing
from rehab_app.grasp.contact import hold, search
from rehab_app.grasp.hand import GraspHand, human_hand, parse_hand, robot_hand
from rehab_app.grasp.objects import Box, Cylinder, Sphere, Thing
from rehab_app.grasp.posture import Posture, find_posture, try_posture
from robot_iface.kinematics import average_hand, forward
from robot_iface.kinematics.dlr_hit import hand_points
from sessions.records import DIGITS, JOINTS

LINKS = ("proximal", "medial", "distal")


def gaps_by_mujoco(posture: Posture, thing: Thing) -> np.ndarray:
    """Surface distances of the links of thumb and fingers, shape (5, 3), m."""
    spec = mujoco.MjSpec()
    if isinstance(thing, Box):
        size = [thing.depth_m / 2, thing.width_m / 2, 0.5]
        spec.worldbody.add_geom(name="thing", type=mujoco.mjtGeom.mjGEOM_BOX, size=size)
    elif isinstance(thing, Sphere):
        spec.worldbody.add_geom(name="thing", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[thing.radius_m, 0, 0])
    else:
        spec.worldbody.add_geom(
            name="thing", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[thing.radius_m, 0.5, 0]
        )
    half_m = np.vstack([posture.hand.thumb_half_m, posture.hand.half_m])
    for digit in range(5):
        for link in range(3):
            ends = posture.points_m[digit, link : link + 2].ravel()
            spec.worldbody.add_geom(
                name=f"{digit}{link}",
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=ends,
                size=[float(half_m[digit, link]), 0, 0],
            )
    spec.option.ccd_tolerance = 1e-9
    model = spec.compile()
    state = mujoco.MjData(model)
    mujoco.mj_kinematics(model, state)
    found = np.empty((5, 3))
    for digit in range(5):
        for link in range(3):
            ids = model.geom("thing").id, model.geom(f"{digit}{link}").id
            found[digit, link] = mujoco.mj_geomDistance(model, state, *ids, 1.0, None)
    return found


@pytest.mark.parametrize("grip", ["transverse", "diagonal"])
def test_nothing_cuts_and_what_touches_touches(grip: str) -> None:
    refused = []
    for length_m in (0.160, 0.185, 0.210):
        hand = human_hand(average_hand(length_m))
        for radius_m in np.arange(0.010, 0.0605, 0.0125):
            thing = Cylinder(float(radius_m))
            try:
                posture = try_posture(hand, thing, grip, "contact", None)
            except Refused as refusal:
                refused.append(f"{radius_m:.4f} {length_m}: {refusal}")
                continue
            assert posture.penetration_m <= 1e-5
            gaps = gaps_by_mujoco(posture, thing)
            assert gaps.min() >= -1e-5
            for at in posture.contacts:
                if at.digit != "palm":
                    links = ("metacarpal", *LINKS[::2]) if at.digit == "thumb" else LINKS
                    assert abs(gaps[DIGITS.index(at.digit), links.index(at.link)]) <= 2e-5, at
            assert all(math.isfinite(angle) for angle in posture.angles_rad.values())
    assert len(refused) <= 2, refused


@pytest.mark.parametrize("thing", [Sphere(0.035), Box(0.04, 0.045), Cylinder(0.02)])
def test_other_things_are_met_too(thing: Thing) -> None:
    posture = try_posture(parse_hand("human"), thing, "transverse", "contact", None)
    gaps = gaps_by_mujoco(posture, thing)
    assert gaps[1:].min() >= -1e-5
    assert (gaps[1:, 1:].min(axis=1) <= 2e-5).all()


def points_from_angles(posture: Posture) -> np.ndarray:
    """The hand's own kinematics at the posture's angles: palm frame, right hand, shape (5, 4, 3)."""
    hand, angles = posture.hand, posture.angles_rad
    if hand.robot is not None:
        named = [("thumb_cmc_abduction", "thumb_cmc_flexion", "thumb_mcp_flexion")]
        named += [
            (f"{f}_mcp_abduction", f"{f}_mcp_flexion", f"{f}_pip")
            for f in ("index", "middle", "ring", "little")
        ]
        return hand_points(hand.robot, np.array([[angles[name] for name in row] for row in named]))
    assert hand.person is not None
    joints = np.zeros(21)
    for name, angle in angles.items():
        joints[JOINTS.index(name)] = angle
    return (forward(hand.person, joints).landmarks_m[:20] * hand.person.mirror).reshape(5, 4, 3)


@pytest.mark.parametrize(
    "hand", [robot_hand(), human_hand(average_hand(0.18, "left"))], ids=["robot", "left"]
)
def test_the_angles_put_the_hand_where_the_posture_says(hand: GraspHand) -> None:
    posture = find_posture(hand, Cylinder(0.0225))
    ours = np.concatenate([points_from_angles(posture)[:1], points_from_angles(posture)[1:]])
    distances = np.linalg.norm(ours[:, None, :, None] - ours[None, :, None, :], axis=-1)
    placed = posture.points_m
    expected = np.linalg.norm(placed[:, None, :, None] - placed[None, :, None, :], axis=-1)
    assert np.abs(distances - expected).max() < 1e-9


def test_left_and_right_hands_take_the_same_angles() -> None:
    left, right = (human_hand(average_hand(0.18, side)) for side in ("left", "right"))
    ours = find_posture(left, Cylinder(0.03))
    assert ours.angles_rad == find_posture(right, Cylinder(0.03)).angles_rad


def test_the_object_moves_along_the_row_of_knuckles_with_its_inclination() -> None:
    hand = robot_hand()
    closing = FingerClosing(hand, Cylinder(0.03))
    alpha = 0.3
    heights = closing.heights_m(np.array([0.01]), np.array([alpha]))[0] / math.cos(alpha)
    lateral = hand.knuckles_m[:, 1] - hand.knuckles_m[3, 1]
    distal = hand.knuckles_m[:, 2] - hand.knuckles_m[3, 2]
    assert heights == pytest.approx(0.01 + distal + lateral * math.tan(alpha), abs=1e-12)


def test_no_place_nearby_or_far_is_better() -> None:
    closing = FingerClosing(parse_hand("human"), Cylinder(0.03))
    best = search(closing, (-0.02, 0.06), (-0.2, 0.2), (0, 1, 2, 3))
    rng = np.random.default_rng(61)
    for _ in range(60):
        other = hold(closing, float(rng.uniform(-0.02, 0.06)), float(rng.uniform(-0.2, 0.2)))
        volar = closing.heights_m(np.array([other.z_m]), np.array([other.alpha_rad])).min() >= 0
        assert not volar or other.objective_m >= best.objective_m - 2e-5


def test_the_lowest_cell_of_the_grid_need_not_be_the_lowest_valley() -> None:
    hand = human_hand(average_hand(0.19))
    best = search(FingerClosing(hand, Cylinder(0.012)), (-0.019, 0.0665), (-0.26, 0.26), (0, 1, 2, 3))
    assert best.objective_m < 0.197  # the valley of the grid's lowest cell ends at .1981


def test_human_radii_around_60_mm() -> None:
    measured = {"index": (28, 33), "middle": (37, 32), "ring": (37, 38), "little": (43, 32)}  # Table 5.4
    posture = find_posture(parse_hand("human:length=0.189"), Cylinder(0.030))
    found = np.array([[posture.radius_m[digit][joint] for joint in ("pip", "dip")] for digit in measured])
    assert np.abs(1e3 * found / np.array(list(measured.values())) - 1).mean() <= 0.23
    assert math.degrees(posture.aperture_rad) == pytest.approx(56.08, abs=1.0)


@pytest.mark.parametrize("radius_m", [0.002, 0.15])
def test_what_no_hand_can_hold_is_refused_with_the_range(radius_m: float) -> None:
    with pytest.raises(Refused, match=r"cylinder radius is .* must be 0\.\d+ to 0\.\d+ m for this hand"):
        find_posture(parse_hand("human"), Cylinder(radius_m))
    with pytest.raises(Refused, match="above 0 m"):
        Cylinder(-radius_m)
    with pytest.raises(Refused, match="inclination"):
        find_posture(robot_hand(), Cylinder(0.0225), alpha_rad=1.2)
    with pytest.raises(Refused, match="a cylinder for method thesis"):
        find_posture(robot_hand(), Sphere(0.0225), method="thesis")
