"""The thesis's own posture against its tables and against another optimiser."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

from rehab_app.errors import Refused
from rehab_app.grasp.curvature import joint_curvature_per_m, joint_radius_m
from rehab_app.grasp.hand import coupled, human_hand, parse_hand, robot_hand
from rehab_app.grasp.newton import TangentObjective
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import Posture, find_posture
from rehab_app.grasp.tangent import distance_terms, heights_m, projected_length_m, tangent
from robot_iface.kinematics import average_hand

# Table 5.4, r = 22.5 mm; the ring finger's PIP is printed .24.
ROBOT_MM = {"index": (25, 19), "middle": (22, 16), "ring": (24, 18), "little": (27, 20)}
ALGORITHM_MM = {"index": (24, 29), "middle": (24, 28), "ring": (23, 30)}


def radius_errors(posture: Posture, table: dict[str, tuple[int, int]]) -> np.ndarray:
    found = np.array([[posture.radius_m[digit][joint] for joint in ("pip", "dip")] for digit in table])
    return np.abs(1e3 * found / np.array(list(table.values())) - 1.0)


def test_robot_radii_of_table_5_4() -> None:
    posture = find_posture(robot_hand(), Cylinder(0.0225), "transverse", "thesis", 0.0)
    errors = radius_errors(posture, ROBOT_MM)
    assert errors.max() <= 0.12
    assert errors.mean() <= 0.08
    assert 1e3 * posture.radius_m["index"]["pip"] == pytest.approx(22.3, abs=0.05)
    assert 1e3 * posture.radius_m["little"]["dip"] == pytest.approx(18.7, abs=0.05)


def test_algorithm_radii_of_table_5_4() -> None:
    hand = coupled(robot_hand(), 2.0 / 3.0)
    errors = radius_errors(find_posture(hand, Cylinder(0.0225), "transverse", "thesis", 0.0), ALGORITHM_MM)
    assert errors.max() <= 0.22
    assert errors.mean() <= 0.15


def test_the_optimum_is_found_from_every_start() -> None:
    objective = TangentObjective(robot_hand())
    rng = np.random.default_rng(51)
    for _ in range(300):
        start = float(rng.uniform(-0.1, 0.1)), float(rng.uniform(-1.0, 1.0))
        found = objective.minimum(0.0225, start=start)
        assert 1e3 * found.z_m == pytest.approx(-7.262, abs=1e-3)
        assert math.degrees(found.alpha_rad) == pytest.approx(-10.251, abs=1e-3)
        assert found.objective_m == pytest.approx(0.264669, abs=1e-6)


@pytest.mark.parametrize("name", ["dlr-hit-ii", "human:length=0.175"])
def test_another_optimiser_agrees(name: str) -> None:
    objective = TangentObjective(parse_hand(name))
    for radius_m in (0.022, 0.03, 0.05):
        found = objective.minimum(radius_m)
        tolerance = {"xatol": 1e-12, "fatol": 1e-16, "maxiter": 4000}
        peer = minimize(
            lambda x, r=radius_m: objective.value(x[0], math.tan(x[1]), r),
            [0, 0],
            method="Nelder-Mead",
            options=tolerance,
        )
        assert found.objective_m <= float(peer.fun) + 1e-12
        assert found.z_m == pytest.approx(float(peer.x[0]), abs=2e-8)  # the peer sees f only, flat to 1e-16


def test_many_at_once_are_those_one_by_one() -> None:
    radius_m = np.random.default_rng(52).uniform(0.018, 0.06, 700)
    for name in ("dlr-hit-ii", "human"):
        objective = TangentObjective(parse_hand(name))
        for alpha in (None, np.full(700, -0.1)):
            z, angle, value = objective.minima(radius_m, alpha)
            for row in range(0, 700, 50):
                one = objective.minimum(float(radius_m[row]), None if alpha is None else -0.1)
                assert z[row] == pytest.approx(one.z_m, abs=1e-10)
                assert angle[row] == pytest.approx(one.alpha_rad, abs=1e-9)
                assert value[row] == pytest.approx(one.objective_m, abs=1e-10)


def test_derivatives_and_symmetry_of_the_distance() -> None:
    terms = (0.0225, 0.055, 0.025, (0.031, 0.0175, 0.013))
    step = 1e-5
    for u in np.random.default_rng(53).uniform(-0.1, 0.1, 50):
        value, slope, bend = distance_terms(float(u), *terms)
        before, after = distance_terms(float(u) - step, *terms), distance_terms(float(u) + step, *terms)
        assert slope == pytest.approx((after[0] - before[0]) / (2 * step), abs=1e-6)
        assert bend == pytest.approx((after[1] - before[1]) / (2 * step), rel=1e-5)
        assert value == pytest.approx(distance_terms(-float(u), *terms)[0], abs=1e-15)
        assert bend > 0
    hand = robot_hand()
    together = tangent(heights_m(hand, 0.01, 0.1), 0.0225, hand.links_m, hand.palm_half_m, hand.half_m)
    direct = TangentObjective(hand).value(0.01, math.tan(0.1), 0.0225)
    assert (together.centre_m - 0.0225).sum() == pytest.approx(direct, abs=1e-15)


def test_below_12_49_mm_the_middle_is_a_maximum() -> None:
    rest = (0.055, 0.025, (0.031, 0.0175, 0.013))
    assert distance_terms(0.0, 0.01250, *rest)[2] > 0 > distance_terms(0.0, 0.01248, *rest)[2]


def test_links_are_tangent_where_the_angles_say() -> None:
    hand = robot_hand()
    u = heights_m(hand, -0.0072, -0.17)
    touch = tangent(u, 0.0225, hand.links_m, hand.palm_half_m, hand.half_m)
    for finger in range(4):
        knuckle = np.array([-(0.0225 + hand.palm_half_m), u[finger]])
        first = np.array([np.sin(touch.mcp_rad[finger]), np.cos(touch.mcp_rad[finger])])
        bend = touch.mcp_rad[finger] + touch.pip_rad[finger]
        second = np.array([np.sin(bend), np.cos(bend)])
        middle = knuckle + hand.links_m[finger, 0] * first
        assert abs(knuckle[0] * first[1] - knuckle[1] * first[0]) == pytest.approx(0.040, abs=1e-12)
        assert abs(middle[0] * second[1] - middle[1] * second[0]) == pytest.approx(0.0355, abs=1e-12)


def test_equation_5_6_is_the_true_projection() -> None:
    rng = np.random.default_rng(54)
    plane = rng.normal(size=(2, 2000, 3))
    plane /= np.linalg.norm(plane, axis=-1, keepdims=True)
    finger, section = plane
    link = np.cross(finger, rng.normal(size=(2000, 3)))
    true = np.linalg.norm(link - (link * section).sum(axis=1, keepdims=True) * section, axis=1)
    assert np.abs(projected_length_m(link, finger, section) - true).max() < 1e-12
    assert projected_length_m(link, finger, finger) == pytest.approx(np.linalg.norm(link, axis=1), abs=1e-12)


def test_curvature_is_that_of_the_natural_spline() -> None:
    rng = np.random.default_rng(55)
    for points in np.cumsum(rng.uniform(0.01, 0.04, (50, 4, 3)) * rng.choice([1, 1, -1], (50, 1, 3)), axis=1):
        knots = np.r_[0, np.cumsum(np.sqrt(np.linalg.norm(np.diff(points, axis=0), axis=1)))]
        spline = CubicSpline(knots, points, bc_type="natural")
        first, second = spline(knots, 1), spline(knots, 2)
        expected = np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3
        assert joint_curvature_per_m(points) == pytest.approx(expected, abs=1e-6)
        assert (joint_curvature_per_m(points)[[0, 3]] == 0).all()
    assert np.isinf(joint_radius_m(np.array([[0.0, 0], [1, 1], [3, 3], [4, 4]]))).all()


def test_what_the_tangent_posture_cannot_do_is_refused() -> None:
    robot = robot_hand()
    for radius_m, words in ((0.012, "PIP angle.*0.0149.*m for this hand"), (0.15, "contact.*for this hand")):
        with pytest.raises(Refused, match=words):
            find_posture(robot, Cylinder(radius_m), "transverse", "thesis")
    tangent_warnings = find_posture(robot, Cylinder(0.0225), "transverse", "thesis").warnings
    assert any("cuts 17." in said for said in tangent_warnings)
    assert human_hand(average_hand(0.189, "left")).side == "left"
