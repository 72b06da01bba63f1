"""Hand-shape measures: laws, closed forms, and the arithmetic of the thesis's tables."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.grasp.curvature import joint_radius_m
from rehab_app.grasp.shape import abduction_rad, aperture_rad, hand_shape, opposition_rad
from rehab_app.grasp.shape_spread import spread
from rehab_app.grasp.shape_tables import APERTURE_DEG, GLOVE_APERTURE_DEG, INDEX_RADIUS_MM, table_spread
from rehab_app.grasp.shape_take import closed_rows
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, average_hand, forward
from robot_iface.kinematics.dlr_hit import THUMB_INCLINATION_RAD, THUMB_OPPOSITION_RAD
from sessions.errors import Refused
from sessions.records import JOINTS, LANDMARKS, Side
from sessions.records.fields import Float64


def hands(frames: int, side: Side = "right") -> Float64:
    draw = np.random.default_rng(5).uniform(0.1, 0.9, (frames, 21))
    return forward(
        average_hand(0.189, side), JOINT_MIN_RAD + draw * (JOINT_MAX_RAD - JOINT_MIN_RAD)
    ).landmarks_m


def at(name: str) -> int:
    return LANDMARKS.index(name)


def test_means_of_the_tables_of_chapter_3() -> None:
    # sums worked by hand: 486.00 / 10, then 367.34, 392.55, 221.51, 202.35, 248.71 and 232.23 over 7
    assert float(table_spread(GLOVE_APERTURE_DEG).mean) == pytest.approx(48.60, abs=0.01)
    assert float(table_spread(APERTURE_DEG["diagonal"]).mean) == pytest.approx(52.48, abs=0.01)
    assert float(table_spread(APERTURE_DEG["transverse"]).mean) == pytest.approx(56.08, abs=0.01)
    means = {("pip", "diagonal"): 31.64, ("pip", "transverse"): 28.91}
    means |= {("dip", "diagonal"): 35.53, ("dip", "transverse"): 33.18}
    for rows, mean in means.items():
        assert float(table_spread(INDEX_RADIUS_MM[rows]).mean) == pytest.approx(mean, abs=0.01)


def test_mean_and_deviation_leave_out_what_is_missing() -> None:
    found = spread(np.array([[1.0, np.nan, np.inf], [3.0, 4.0, np.nan], [5.0, np.nan, np.nan]]))
    np.testing.assert_allclose(found.mean, [3.0, 4.0, np.nan])
    np.testing.assert_allclose(found.sd, [2.0, np.nan, np.nan])
    assert found.count.tolist() == [3, 1, 0]


def test_measures_are_those_of_a_turned_hand_and_of_its_mirror_image() -> None:
    right, left = hands(50), hands(50, "left")
    turned = right @ Rotation.from_rotvec([0.4, -1.0, 2.0]).as_matrix().T + [0.3, -0.2, 0.9]
    one, other, moved = hand_shape(right, "right"), hand_shape(left, "left"), hand_shape(turned, "right")
    for name in ("aperture_rad", "curvature_per_m", "pip_distance_m", "abduction_rad"):
        np.testing.assert_allclose(getattr(moved, name), getattr(one, name), rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(other.opposition_rad, one.opposition_rad, atol=1e-12)


def test_angles_of_a_hand_laid_out_by_hand() -> None:
    p_m = hands(1)
    p_m[0, at("wrist")], p_m[0, at("index_mcp")] = 0.0, [0.0, 0.0, 0.08]
    p_m[0, at("thumb_mcp")] = [0.0, 0.05 * np.sin(0.9), 0.05 * np.cos(0.9)]
    assert aperture_rad(p_m)[0] == pytest.approx(0.9)
    # proximal bones of any lengths that meet at one knuckle: their PIPs subtend the angle between them
    for name, angle, bone_m in (("index", 0.2, 0.041), ("middle", -0.15, 0.049)):
        p_m[0, at(f"{name}_mcp")] = [0.0, 0.0, 0.08]
        p_m[0, at(f"{name}_pip")] = [0.0, bone_m * np.sin(angle), 0.08 + bone_m * np.cos(angle)]
    assert abduction_rad(p_m)[0, 0] == pytest.approx(0.35)
    # a thumb in the direction that the DLR-HIT-Hand II has it fixed in: 35.51 and 44.13 deg
    up, out = np.cos(THUMB_INCLINATION_RAD), np.sin(THUMB_INCLINATION_RAD)
    along = np.array([out * np.cos(THUMB_OPPOSITION_RAD), out * np.sin(THUMB_OPPOSITION_RAD), up])
    p_m[0, at("thumb_cmc")] = p_m[0, at("index_mcp")] + 0.03 * along
    p_m[0, at("thumb_mcp")] = p_m[0, at("thumb_cmc")] + 0.05 * along
    assert np.degrees(opposition_rad(p_m, "right")[0]) == pytest.approx([35.51, 44.13])


def test_curvature_is_0_at_the_ends_and_in_a_straight_digit() -> None:
    shape = hand_shape(hands(40), "right")
    assert (shape.curvature_per_m[..., [0, 3]] == 0).all()
    assert (shape.curvature_per_m[..., 1:3] > 0).all()
    straight = hand_shape(forward(average_hand(0.189, "right"), np.zeros((1, 21))).landmarks_m, "right")
    assert (straight.curvature_per_m[:, 1:] == 0).all()
    assert np.isposinf(straight.radius_m[:, 1:]).all()
    np.testing.assert_allclose(shape.radius_m[:, 1], joint_radius_m(hands(40)[:, 4:8]))


def test_a_lost_landmark_is_lost_only_where_it_counts() -> None:
    p_m = hands(3)
    p_m[1, at("middle_dip")] = np.nan
    p_m[2, at("wrist")] = np.nan
    shape = hand_shape(p_m, "right")
    assert np.isnan(shape.curvature_per_m[1, 2]).all()
    assert np.isfinite(np.delete(shape.curvature_per_m[1], 2, axis=0)).all()
    assert np.isfinite(shape.abduction_rad).all()
    assert np.isnan(shape.aperture_rad).tolist() == [False, False, True]
    with pytest.raises(Refused, match="25, 3"):
        hand_shape(p_m[:, :24], "right")


def test_closings_end_where_the_hand_is_closed() -> None:
    t_s = np.arange(0, 12.0, 0.01)
    joints = np.zeros((t_s.size, 21))
    joints[:, JOINTS.index("index_pip")] = 0.6 * (1 - np.cos(2 * np.pi * t_s / 4.0))
    np.testing.assert_allclose(t_s[closed_rows(t_s, joints)], [2.0, 6.0, 10.0], atol=0.05)
    assert not closed_rows(t_s, np.zeros((t_s.size, 21))).size
    held = np.zeros((t_s.size, 21))
    held[:, JOINTS.index("index_pip")] = 1.2 * np.clip((t_s - 1.0) / 2.0, 0.0, 1.0)
    ends = closed_rows(t_s, held)
    assert len(ends) == 1
    assert held[ends[0]].max() == pytest.approx(1.2, abs=0.02)
