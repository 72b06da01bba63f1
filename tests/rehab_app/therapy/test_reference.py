from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from rehab_app.recording.take import HandMotion
from rehab_app.therapy.reference import BuiltReference, build_reference
from rehab_app.therapy.reference_place import whole_hand
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand, couple_dip, forward
from robot_iface.motion import QuinticPath, check_path
from robot_iface.safety import shipped_limits
from robot_iface.types import Hull, Limits
from sessions.errors import Refused
from sessions.records import DIGITS, FINGERS, JOINTS, Status
from sessions.records.fields import Float64

DRIVEN = (
    "thumb_cmc_flexion",
    "thumb_cmc_abduction",
    "thumb_mcp_flexion",
    "thumb_ip",
    *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_flexion", "pip")),
)
WIDE = Limits(
    q_min_rad=np.full(12, np.deg2rad(-30.0)),
    q_max_rad=np.full(12, np.deg2rad(110.0)),
    flexion_speed_rad_s=np.full(12, np.deg2rad(60.0)),
    extension_speed_rad_s=np.full(12, np.deg2rad(30.0)),
    tau_interaction_nm=np.full(12, 0.25),
    tau_nm=np.full(12, 0.6),
)
INDEX_PIP = JOINTS.index("index_pip")


def closing(reach_rad: float = 0.5, period_s: float = 6.0, still_s: float = 2.0) -> tuple[Float64, Float64]:
    """Time (N,) and angles (N, 21) of fingers that close and open once, still before and after."""
    t_s = np.arange(0.0, period_s + 2 * still_s, 0.01)
    phase = np.clip((t_s - still_s) / period_s, 0, 1)
    joints = np.zeros((t_s.size, 21))
    for row, name in enumerate(JOINTS):
        if name.endswith(("mcp_flexion", "pip")):
            joints[:, row] = 0.15 + reach_rad * 0.5 * (1 - np.cos(2 * np.pi * phase))
    return t_s, couple_dip(joints)


def motion(t_s: Float64, joints: Float64, noise_rad: float = 0.0, seed: int = 1) -> HandMotion:
    rng = np.random.default_rng(seed)
    seen = joints + noise_rad * rng.standard_normal(joints.shape)
    std = max(noise_rad, 0.005)
    geometry = average_hand()
    tips = forward(geometry, np.nan_to_num(seen)).landmarks_m[:, [3, 7, 11, 15, 19]]
    return HandMotion(
        t_ns=np.round(1e9 * t_s).astype(np.int64),
        t_s=t_s,
        joints_rad=seen,
        joint_covariance_rad2=np.tile(std**2 * np.eye(21), (t_s.size, 1, 1)),
        joint_status=np.where(np.isfinite(seen), Status.MEASURED, Status.LOST).astype(np.uint8),
        fingertips_palm_m=tips,
        p_camera_palm_m=np.zeros((t_s.size, 3)),
        q_camera_palm_wxyz=np.tile([1.0, 0, 0, 0], (t_s.size, 1)),
        residual_m=np.zeros(t_s.size),
        side="right",
        geometry=geometry,
    )


def build(take: HandMotion, limits: Limits = WIDE, **options: Any) -> BuiltReference:
    order: dict[str, Any] = {"driven_joints": DRIVEN, **options}
    return build_reference(
        take,
        patient_geometry=average_hand(0.175),
        patient_side="left",
        limits=limits,
        take_digest="0" * 64,
        **order,
    )


def test_the_path_is_the_movement_without_its_noise() -> None:
    t_s, joints = closing()
    built = build(motion(t_s, joints, np.deg2rad(2)))
    truth = np.interp(built.take_start_s + built.path.t_s, t_s, joints[:, INDEX_PIP])
    error = built.path.q_rad[:, DRIVEN.index("index_pip")] - truth
    assert np.sqrt(np.mean(error**2)) < np.deg2rad(0.8)
    assert built.path.side == "left"
    assert built.path.joint_names == DRIVEN


def test_still_ends_are_trimmed_and_said_so() -> None:
    t_s, joints = closing(still_s=3.0)
    take = motion(t_s, joints)
    built = build(take)
    assert 6.0 < built.path.t_s[-1] < 7.2
    assert any("trimmed" in note for note in built.notes)
    whole = build(take, trim_still=False)
    assert whole.path.t_s[-1] == pytest.approx(t_s[-1], abs=0.05)
    assert not any("trimmed" in note for note in whole.notes)


@pytest.mark.parametrize(("reach_deg", "told"), [(3.0, True), (8.0, False)])
def test_a_take_that_hardly_moves_is_told_first(reach_deg: float, told: bool) -> None:
    built = build(motion(*closing(reach_rad=np.deg2rad(reach_deg))))
    said = [note for note in built.notes if "hardly moves" in note]
    assert bool(said) is told
    assert not told or (built.notes[0] == said[0] and " 3 deg" in said[0])


@pytest.mark.parametrize("still_s", [0.0, 2.0])
def test_the_path_begins_and_ends_at_rest(still_s: float) -> None:
    t_s, joints = closing(still_s=still_s)
    inside = slice(60, -60) if still_s == 0.0 else slice(None)  # cut into the movement
    built = build(motion(t_s[inside] - t_s[inside][0], joints[inside]))
    spline = QuinticPath(built.path)
    ends = spline.sample(np.array([0.0, spline.duration_s]), 1)
    assert np.abs(ends).max() < np.deg2rad(1.5)


def test_the_fastest_speed_is_just_allowed() -> None:
    t_s, joints = closing(reach_rad=1.2, period_s=3.0)
    built = build(motion(t_s, joints))
    assert built.fastest_speed < 0.6
    assert "into extension" in built.fastest_reason
    assert "30 deg/s" in built.fastest_reason
    path = QuinticPath(built.path)
    assert check_path(path, WIDE, built.fastest_speed, 0.001) is None
    assert check_path(path, WIDE, 1.1 * built.fastest_speed, 0.001) is not None


def test_a_slow_movement_has_no_fastest_reason() -> None:
    t_s, joints = closing(reach_rad=0.3, period_s=10.0)
    built = build(motion(t_s, joints))
    assert built.fastest_speed == 1.0
    assert built.fastest_reason == ""


def test_limits_clip_aloud_and_never_let_through() -> None:
    t_s, joints = closing(reach_rad=1.0)
    narrow = replace(WIDE, q_min_rad=np.full(12, 0.0), q_max_rad=np.full(12, np.deg2rad(50.0)))
    built = build(motion(t_s, joints), narrow)
    over = np.rad2deg(1.15) - 50
    assert any(
        f"clipped index_pip by {over:.0f} deg at its upper end (50 deg)" in note for note in built.notes
    )
    assert check_path(QuinticPath(built.path), narrow, built.fastest_speed, 0.001) is None
    assert built.residual_m["index"] > 0.01


def test_random_takes_keep_their_limits() -> None:
    rng = np.random.default_rng(3)
    t_s = np.arange(0.0, 8.0, 1 / 30)
    for seed in range(5):
        knots = rng.uniform(-1.0, 2.5, (9, 21))
        joints = np.stack([np.interp(t_s, np.linspace(0, 8, 9), knots[:, j]) for j in range(21)], axis=1)
        limits = replace(WIDE, q_min_rad=np.zeros(12), q_max_rad=rng.uniform(0.2, 1.6, 12))
        built = build(motion(t_s, joints, 0.03, seed), limits)
        assert check_path(QuinticPath(built.path), limits, built.fastest_speed, 0.001) is None


def test_the_budget_is_what_the_robot_cannot_show() -> None:
    t_s, joints = closing()
    assert max(build(motion(t_s, joints)).residual_m.values()) < 0.0005
    spread = joints.copy()
    spread[:, JOINTS.index("ring_mcp_abduction")] = np.deg2rad(10)
    budget = build(motion(t_s, spread)).residual_m
    assert set(budget) == set(DIGITS)
    assert 0.010 < budget["ring"] < 0.020  # 10 deg on some 88 mm
    assert budget["index"] < 0.0005


def test_gaps_are_bridged_and_named() -> None:
    t_s, joints = closing()
    seen = joints.copy()
    seen[400:520, 5:9] = np.nan
    seen[:, JOINTS.index("thumb_ip")] = np.nan
    built = build(motion(t_s, seen))
    assert any(note.startswith("index_pip was not seen for 1.2 s from 4.0 s") for note in built.notes)
    assert any("thumb_ip was never seen" in note for note in built.notes)
    truth = np.interp(built.take_start_s + built.path.t_s, t_s, joints[:, INDEX_PIP])
    error = built.path.q_rad[:, DRIVEN.index("index_pip")] - truth
    assert np.abs(error).max() < np.deg2rad(8)


def test_the_same_take_gives_the_same_path() -> None:
    t_s, joints = closing()
    take = motion(t_s, joints, 0.02)
    np.testing.assert_array_equal(build(take).path.q_rad, build(take).path.q_rad)


def test_the_whole_hand_couples_what_is_not_driven() -> None:
    driven = np.random.default_rng(4).uniform(0, 1, (5, 12))
    joints = whole_hand(driven, DRIVEN)
    np.testing.assert_allclose(joints[:, INDEX_PIP + 1], 2 / 3 * joints[:, INDEX_PIP])
    np.testing.assert_array_equal(joints[:, JOINTS.index("index_mcp_abduction")], 0.0)
    np.testing.assert_array_equal(joints[:, JOINTS.index("thumb_ip")], driven[:, 3])


def test_what_cannot_be_played_is_refused() -> None:
    t_s, joints = closing()
    with pytest.raises(Refused, match="without driven joints"):
        build(motion(t_s, np.full_like(joints, np.nan)))
    short = joints.copy()
    short[90:] = np.nan
    with pytest.raises(Refused, match="1 s or longer"):
        build(motion(t_s, short))
    with pytest.raises(Refused, match="5 to 500"):
        build(motion(t_s, joints), jerk_rad_s3=0.0)


def test_a_take_is_retargeted_to_a_robot_with_its_own_chain() -> None:
    t_s, joints = closing(reach_rad=1.4)
    robot = capabilities("dlr-hit-ii")
    bounds = shipped_limits(robot.joint_names, robot.q_min_rad, robot.q_max_rad)
    built = build(motion(t_s, joints), bounds, driven_joints=robot.joint_names, device=robot)
    assert built.path.joint_names == robot.joint_names
    assert check_path(QuinticPath(built.path), bounds, built.fastest_speed, 0.001) is None
    assert set(built.residual_m) == set(DIGITS)
    assert max(value for digit, value in built.residual_m.items() if digit != "thumb") < 0.012
    stretched = joints.copy()
    stretched[:, JOINTS.index("ring_mcp_abduction")] = np.deg2rad(20)
    notes = build(motion(t_s, stretched), bounds, driven_joints=robot.joint_names, device=robot).notes
    said = [note for note in notes if "ring_mcp_abduction would be at 20 deg, its end is 15 deg" in note]
    assert len(said) == 1
    assert "s of the take" in said[0]
    with pytest.raises(Refused, match="those of its chain"):
        build(motion(t_s, joints), bounds, driven_joints=robot.joint_names[::-1], device=robot)


def test_a_path_is_pulled_into_what_two_joints_may_share() -> None:
    t_s, joints = closing(reach_rad=1.2)
    corners = np.deg2rad([[-5.0, -5.0], [90.0, -5.0], [-5.0, 90.0]])
    hull = Hull(("index_mcp_flexion", "index_pip"), corners)
    take = motion(t_s, joints)
    free, held = build(take), build(take, replace(WIDE, hulls=(hull,)))
    pair = [DRIVEN.index(name) for name in hull.joints]
    fine = QuinticPath(held.path).sample(np.linspace(0.0, held.path.t_s[-1], 4000))
    assert fine[:, pair].sum(axis=1).max() < np.deg2rad(85.0)
    assert free.path.q_rad[:, pair].sum(axis=1).max() > np.deg2rad(120.0)
    others = [  # the thumb may be led past the fingers in another way
        column for column, name in enumerate(DRIVEN) if column not in pair and name[:5] != "thumb"
    ]
    np.testing.assert_array_equal(held.path.q_rad[:, others], free.path.q_rad[:, others])
    assert any("is more than these two may bend together: pulled in by" in note for note in held.notes)
    still = build(take, replace(WIDE, hulls=(Hull(("index_mcp_flexion", "index_pip"), 4.0 * corners),)))
    np.testing.assert_array_equal(still.path.q_rad, free.path.q_rad)


def test_a_take_of_either_side_makes_the_same_path_for_either_patient() -> None:
    """Hazard 1: mirrored where the side differs, joint angles keep their meaning."""
    t_s, joints = closing()
    take = motion(t_s, joints, 0.01)
    mirrored = replace(take, side="left", geometry=average_hand(side="left"))
    paths = [
        build_reference(
            shown,
            patient_geometry=average_hand(0.175, side),
            patient_side=side,
            driven_joints=DRIVEN,
            limits=WIDE,
            take_digest="0" * 64,
        ).path
        for shown in (take, mirrored)
        for side in ("right", "left")
    ]
    assert [path.side for path in paths] == ["right", "left", "right", "left"]
    for path in paths[1:]:
        np.testing.assert_allclose(path.q_rad, paths[0].q_rad, atol=1e-9)


def test_what_is_too_unsteady_for_the_limits_is_smoothed_aloud() -> None:
    t_s = np.arange(0.0, 8.0, 1 / 30)
    joints = closing()[1][:1].repeat(t_s.size, axis=0)
    joints[:, INDEX_PIP] += 0.5 * np.sin(2 * np.pi * 3.0 * t_s)
    slow = replace(WIDE, extension_speed_rad_s=np.full(12, np.deg2rad(15.0)))
    built = build(motion(t_s, joints), slow)
    assert any(
        note.startswith("As recorded, the movement is too fast or too unsteady") for note in built.notes
    )
    assert not any("too unsteady" in note for note in build(motion(*closing()), slow).notes)
