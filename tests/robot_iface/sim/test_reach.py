"""A virtual DLR-HIT-Hand II reaches, closes on a cylinder that stands free, and holds it or does not."""

from __future__ import annotations

from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

from rehab_app.grasp.hand import robot_hand
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import Posture, find_posture
from robot_iface.errors import Refused
from robot_iface.sim.dlr_hit import LINK_HALF_M
from robot_iface.sim.reach import TORQUE_CAP_NM, Grasp, finger_torque_nm, reach_and_grasp
from robot_iface.sim.reach_arm import END_M, REACH_S, START_M, arm_inverse, arm_torque_nm, cubic, quintic
from robot_iface.sim.reach_drawing import draw_reach
from robot_iface.sim.reach_world import FreeCylinder
from robot_iface.types import FINGERS, Float64

RADII_M = (0.020, 0.0225)
TOP_M = 0.022
"""The cylinder ends 22 mm radial of the wrist: just under the thumb."""


@cache
def _posture(radius_m: float) -> Posture:
    return find_posture(robot_hand(), Cylinder(radius_m), "transverse", "contact", 0.0)


def _angles_rad(posture: Posture) -> Float64:
    angles = posture.angles_rad
    thumb = [angles[f"thumb_{joint}"] for joint in ("cmc_abduction", "cmc_flexion", "mcp_flexion")]
    long = [[0.0, angles[f"{name}_mcp_flexion"], angles[f"{name}_pip"]] for name in FINGERS]
    return np.array([thumb, *long])


def _distal_m(posture: Posture) -> float:
    return float(robot_hand().knuckles_m[3, 2]) - posture.z_m


@cache
def _grasp(radius_m: float, squeeze_rad: float = 0.3) -> Grasp:
    posture = _posture(radius_m)
    return reach_and_grasp(
        _angles_rad(posture), FreeCylinder(radius_m, _distal_m(posture), TOP_M), squeeze_rad
    )


@pytest.mark.parametrize("radius_m", RADII_M)
def test_the_grasp_holds_against_gravity_and_every_push(radius_m: float) -> None:
    grasp = _grasp(radius_m)
    assert len(grasp.held) == 7
    assert grasp.holds, [(one.push_n.tolist(), one.moved_m) for one in grasp.held]
    assert max(one.moved_m for one in grasp.held) < 0.005


@pytest.mark.parametrize("radius_m", RADII_M)
def test_palm_and_long_fingers_hold_it_and_the_thumb_does_not(radius_m: float) -> None:
    grasp = _grasp(radius_m)
    assert grasp.palm_force_n > 1.0
    assert (grasp.link_force_n[2:].sum(axis=1) > 0.5).all()
    assert grasp.link_force_n[0].sum() == 0.0
    # the real hand gives 10 N at a fingertip
    assert grasp.link_force_n.max() < 10.0


def test_pushes_move_it_and_a_strong_one_takes_it_out() -> None:
    posture = _posture(0.020)
    cylinder = FreeCylinder(0.020, _distal_m(posture), TOP_M)
    away = np.array([[0.0, 0.5, 0.0], [10.0, 0.0, 0.0]])
    held = reach_and_grasp(_angles_rad(posture), cylinder, pushes_n=away).held
    # the arm alone gives way by 0.5 N / 850 N/m
    assert held[1].moved_m > held[0].moved_m + 0.0005
    assert held[1].holds
    assert not held[2].holds


def test_finger_torque_is_the_thesis_law_up_to_what_the_motors_give() -> None:
    still = np.zeros(3)
    soft = finger_torque_nm(still, np.array([0.1, 0.1, 0.1]), np.full(3, 0.2), still)
    np.testing.assert_allclose(soft, [0.06 - 0.002, 0.06 - 0.002, 0.08 - 0.0027])
    np.testing.assert_array_equal(finger_torque_nm(still, still, np.full(3, -9.0), still), -TORQUE_CAP_NM)


def test_a_posture_that_only_touches_does_not_hold() -> None:
    grasp = _grasp(0.020, squeeze_rad=0.0)
    assert not grasp.holds
    assert grasp.held[0].moved_m > 1.0


def test_a_long_cylinder_is_pushed_over_by_the_thumb_on_the_way() -> None:
    posture = _posture(0.020)
    long = FreeCylinder(0.020, _distal_m(posture), top_m=0.08, height_m=0.2)
    grasp = reach_and_grasp(_angles_rad(posture), long)
    reached = round(REACH_S * 100)
    assert np.linalg.norm(grasp.record.object_m[reached] - long.centre_m) > 0.05
    assert not grasp.holds


@pytest.mark.parametrize("radius_m", RADII_M)
def test_the_arm_follows_its_path_and_leaves_the_object_alone(radius_m: float) -> None:
    record = _grasp(radius_m).record
    reached = round(REACH_S * 100)
    assert record.t_s[reached] == pytest.approx(REACH_S)
    error = np.linalg.norm(record.end_m - record.end_reference_m, axis=1)
    assert error[: reached + 1].max() < 0.001
    np.testing.assert_allclose(record.end_m[[0, reached]], [START_M, END_M], atol=5e-4)
    assert np.abs(record.arm_rad.sum(axis=1)).max() < 1e-5  # the hand never turns
    assert np.linalg.norm(record.object_m[reached] - record.object_m[0]) < 5e-4


def test_path_length_and_peak_speed_of_the_reach() -> None:
    t = np.linspace(0.0, REACH_S, 30001)
    share, rate = quintic(t, REACH_S)
    length = float(np.linalg.norm(END_M - START_M))
    assert length == pytest.approx(0.2245, abs=5e-5)
    assert length * rate.max() == pytest.approx(0.1403, abs=5e-5)
    np.testing.assert_allclose(np.gradient(share, t)[1:-1], rate[1:-1], atol=1e-6)
    share, rate = cubic(t, 1.2)
    np.testing.assert_allclose([share[0], share[-1], rate[0], rate[-1]], [0.0, 1.0, 0.0, 0.0], atol=1e-12)


def test_fingers_close_together_within_a_degree_of_the_cubic_until_they_touch() -> None:
    record = _grasp(0.020).record
    half_way = round((REACH_S + 0.5) * 100)
    error = np.abs(record.joints_rad[:half_way, :, :3] - record.reference_rad[:half_way])
    assert np.rad2deg(error.max()) < 1.0
    dip_less_pip = record.joints_rad[..., 3] - record.joints_rad[..., 2]
    assert np.rad2deg(np.abs(dip_less_pip).max()) < 0.1


@pytest.mark.parametrize("radius_m", RADII_M)
def test_no_long_link_sinks_into_the_cylinder(radius_m: float) -> None:
    grasp = _grasp(radius_m)
    points, centre = grasp.record.points_m[-1], grasp.record.object_m[-1]
    inside = [
        np.linalg.norm((a + share * (b - a) - centre)[:2]) - radius_m - LINK_HALF_M[link]
        for digit in (2, 3, 4)
        for link, (a, b) in enumerate(zip(points[digit], points[digit][1:], strict=False))
        for share in np.linspace(0.0, 1.0, 41)
    ]
    # soft contact and the cylinder's tilt of a few degrees
    assert min(inside) > -0.002


def test_the_same_trial_twice_is_the_same_to_the_bit() -> None:
    posture, first = _posture(0.020), _grasp(0.020)
    again = reach_and_grasp(_angles_rad(posture), FreeCylinder(0.020, _distal_m(posture), TOP_M), 0.3)
    for name in ("joints_rad", "points_m", "end_m", "object_m"):
        np.testing.assert_array_equal(getattr(again.record, name), getattr(first.record, name))
    assert [one.moved_m for one in again.held] == [one.moved_m for one in first.held]


def test_arm_inverse_and_the_cartesian_law_agree() -> None:
    for point in (START_M, END_M, np.array([0.1, -0.2])):
        torque, end = arm_torque_nm(arm_inverse(point), np.zeros(2), point, np.zeros(2))
        np.testing.assert_allclose(end, point, atol=1e-12)
        np.testing.assert_allclose(torque, 0.0, atol=1e-9)
    beyond = END_M + np.array([0.0, 0.001])
    torque, _ = arm_torque_nm(arm_inverse(END_M), np.zeros(2), beyond, np.zeros(2))
    # virtual work: 0.85 N along y at the end, lever arm x from the shoulder
    assert torque[0] == pytest.approx(0.85 * float(END_M[0]), abs=1e-9)


@pytest.mark.parametrize(
    ("posture", "squeeze", "words"),
    [
        (np.zeros((4, 3)), 0.3, "shape"),
        (np.full((5, 3), np.nan), 0.3, "finite"),
        (np.full((5, 3), 2.0), 0.3, "abduction"),
        (np.zeros((5, 3)), 2.0, "squeeze"),
    ],
)
def test_bad_input_is_refused_with_its_bound(posture: Float64, squeeze: float, words: str) -> None:
    with pytest.raises(Refused, match=words):
        reach_and_grasp(posture, FreeCylinder(0.02, 0.095, TOP_M), squeeze)


@pytest.mark.parametrize("field", ["radius_m", "mass_kg", "friction", "height_m"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_cylinder_that_cannot_be_is_refused(field: str, value: float) -> None:
    sizes = {"radius_m": 0.02, "distal_m": 0.095, "top_m": 0.02} | {field: value}
    with pytest.raises(Refused, match=field):
        FreeCylinder(**sizes)


def test_an_arm_does_not_reach_beyond_its_links() -> None:
    with pytest.raises(Refused, match="shoulder"):
        arm_inverse(np.array([0.0, -0.5]))


def test_the_drawing_shows_every_digit_in_both_spaces() -> None:
    root = ElementTree.fromstring(draw_reach(_grasp(0.020)))
    lines = [line for line in root.iter() if line.tag.endswith("polyline")]
    # from above: four points of five digits; over time: MCP and PIP, ordered and done
    assert len(lines) == 5 * 4 + 5 * 2 * 2
    points = lines[0].attrib["points"].split()
    assert len(points) == (len(_grasp(0.020).record.t_s) - 1) // 4 + 1
    values = np.array(
        [
            [float(part) for part in point.split(",")]
            for line in lines
            for point in line.attrib["points"].split()
        ]
    )
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    assert values.min() >= 0.0
    assert values[:, 0].max() <= width
    assert values[:, 1].max() <= height
