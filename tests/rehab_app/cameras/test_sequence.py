"""Point sequences: their stated shares, their truth against geometry, and what a first second promises."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from rehab_app.cameras.exercise_mix import EXERCISES, level_motion
from rehab_app.cameras.hiding import gaps, open_spots
from rehab_app.cameras.level_scene import level_scene
from rehab_app.cameras.levels import LEVELS, dropped_frames, level_of
from rehab_app.cameras.scene import seen_from
from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.cameras.sequence_file import write_detections_npz
from rehab_app.cameras.skin import Capsules
from rehab_app.cameras.virtual import VirtualCamera
from rehab_app.cameras.virtual_hand import FACING
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.protocol import load_protocol
from robot_iface.types import JOINTS
from sessions.errors import Refused

PROTOCOL = load_protocol("thesis25")


@cache
def sequence(level: str, seed: int = 7, frames: int = 450) -> PointSequence:
    return point_sequence(level, seed, frames)


def test_the_table_of_levels() -> None:
    rows = [
        (one.amplitude, one.speed, one.miss_share, one.centre_std_px, one.clutter, one.persistent)
        for one in LEVELS.values()
    ]
    assert list(LEVELS) == ["easy", "medium", "hard", "extreme"]
    assert rows == [
        (0.3, 0.6, 0.01, 0.4, 0.3, 0),
        (0.65, 1.0, 0.03, 0.6, 1.5, 1),
        (1.0, 1.5, 0.06, 0.9, 3.5, 3),
        (1.0, 2.0, 0.12, 1.3, 9.0, 5),
    ]
    degrees = [round(float(np.rad2deg(one.sway_rad))) for one in LEVELS.values()]
    assert degrees == [10, 20, 32, 45]


@pytest.mark.parametrize("level", LEVELS)
def test_in_the_first_second_every_marker_is_seen_once(level: str) -> None:
    one = sequence(level)
    assert one.visible[:30].all()
    assert not one.dropped[:30].any()
    for owner, other in zip(one.owner[:30], one.other[:30], strict=True):
        held = np.concatenate([owner[owner >= 0], other[other >= 0]])
        assert np.array_equal(np.sort(held), np.arange(25))
    assert np.ptp(one.p_camera_m[:30], axis=0).max() < 1e-12


@pytest.mark.parametrize("level", LEVELS)
def test_shares_are_those_of_the_level(level: str) -> None:
    one, row = sequence(level), LEVELS[level]
    came = np.flatnonzero(~one.dropped)[30:]
    visible = int(one.visible[came].sum())
    held = sum(int((one.owner[k] >= 0).sum() + (one.other[k] >= 0).sum()) for k in came)
    # a merged blob that is missed takes two markers with it, so that the share wavers a little
    assert 1.0 - held / visible == pytest.approx(row.miss_share, abs=0.012)
    false = np.mean([(one.owner[k] < 0).sum() for k in came])
    assert false == pytest.approx(row.clutter + 0.9 * row.persistent, rel=0.15, abs=0.1)
    depths = np.concatenate([one.detections[k].p_camera_m[one.owner[k] >= 0, 2] for k in came])
    assert np.mean(np.isnan(depths)) == pytest.approx(row.hole_share, abs=0.01)
    assert 0.5 * row.dropped_share <= one.dropped.mean() <= 2.5 * row.dropped_share + 5 * row.burst_share


def test_noise_of_centres_and_depths() -> None:
    one = sequence("medium")
    across, along = [], []
    for k, detections in one.received():
        owner = one.owner[k]
        # whole discs only: a partly hidden one is found at the middle of what is seen of it
        good = (owner >= 0) & (one.other[k] < 0) & (k < 30)
        across.append(detections.pixel_px[good] - one.pixel_px[k, owner[good]])
        along.append(detections.p_camera_m[good, 2] - one.p_camera_m[k, owner[good], 2])
    assert np.std(np.concatenate(across)) == pytest.approx(0.6, rel=0.1)
    error = np.concatenate(along)
    error = error[np.isfinite(error)]
    outliers = np.abs(error) > 0.015
    assert outliers.mean() == pytest.approx(0.01, abs=0.01)
    distance = one.p_camera_m[0, :, 2].mean()
    assert np.std(error[~outliers]) == pytest.approx(0.0012 * (distance / 0.7) ** 2, rel=0.15)


def test_truth_projects_onto_itself_and_markers_ride_on_the_hand() -> None:
    one = sequence("hard")
    assert np.allclose(KINECT.project(one.p_camera_m), one.pixel_px)
    height = np.linalg.norm(one.p_camera_m - one.landmarks_camera_m, axis=2)
    assert 0.001 < height.min()
    assert height.max() < 0.016
    assert np.allclose(height, height[0], atol=1e-9)


def test_same_seed_same_sequence_other_seed_another_hand() -> None:
    one, same, other = (point_sequence("hard", seed, 60) for seed in (3, 3, 4))
    for a, b in zip(one.detections, same.detections, strict=True):
        assert np.array_equal(a.pixel_px, b.pixel_px)
    spread = [np.linalg.norm(s.p_camera_m[0, 1:] - s.p_camera_m[0, :-1], axis=1) for s in (one, other)]
    assert np.abs(spread[0] - spread[1]).max() > 0.003


def test_the_order_of_detections_tells_nothing() -> None:
    one = sequence("easy")
    first = [owner[0] for owner in one.owner if len(owner)]
    assert len(set(first)) == 25 or len(set(first)) == 26


def test_a_full_fist_is_deep() -> None:
    motion = level_motion("fist", LEVELS["hard"], 3.0, np.random.default_rng(0))
    closed = np.rad2deg(motion.joints_at(np.linspace(1.2, 3.2, 400)).max(axis=0))
    for finger in ("index", "middle", "ring", "little"):
        assert 75.0 < closed[JOINTS.index(f"{finger}_mcp_flexion")] < 97.0
        assert 88.0 < closed[JOINTS.index(f"{finger}_pip")] < 113.0
        dip, pip = (closed[JOINTS.index(f"{finger}_{joint}")] for joint in ("dip", "pip"))
        assert dip == pytest.approx(pip * 2 / 3, abs=14.0)


@pytest.mark.parametrize("exercise", [*EXERCISES, "mixed"])
def test_every_exercise_begins_still_and_trembles_later(exercise: str) -> None:
    motion = level_motion(exercise, LEVELS["medium"], 6.0, np.random.default_rng(1))
    assert np.ptp(motion.joints_at(np.linspace(0.0, 1.2, 13)), axis=0).max() < 1e-12
    assert motion.duration_s >= 6.0
    assert np.ptp(motion.joints_at(np.linspace(2.5, 6.0, 300)), axis=0).min() > np.deg2rad(0.3)


def test_what_lies_behind_a_capsule_is_hidden() -> None:
    skin = Capsules(np.array([[-0.1, 0.0, 0.5]]), np.array([[0.1, 0.0, 0.5]]), np.array([0.01]))
    points = np.array([[0.0, 0.0, 0.7], [0.0, 0.0, 0.3], [0.0, 0.1, 0.7], [0.3, 0.0, 0.7]])
    near = gaps(points, skin)[:, 0]
    assert near[0] == pytest.approx(0.0, abs=1e-9)  # the line of sight meets the axis
    assert near[1] == pytest.approx(0.2)  # before it
    assert near[2] == pytest.approx(0.5 * 0.1 / np.hypot(0.1, 0.7))  # passes it by
    foot = np.array([0.3, 0.0, 0.7]) * (0.3 * 0.1 + 0.7 * 0.5) / (0.3**2 + 0.7**2)
    assert near[3] == pytest.approx(np.linalg.norm(foot - [0.1, 0.0, 0.5]))  # beyond its end


def test_hiding_agrees_with_the_drawn_picture() -> None:
    scene = level_scene(LEVELS["hard"], "mixed", 12.0, PROTOCOL, "right", np.random.default_rng(5))
    camera = VirtualCamera(scene)
    agree = []
    for t_s in np.linspace(1.5, 11.5, 25):
        posed = scene.at(float(t_s))
        share = open_spots(posed.markers, posed.skin)[1].mean(axis=1)
        cast = (posed.markers.facing() > 0.2) & (share >= 0.5)
        drawn = camera.truth(float(t_s)).seen > 0.5
        agree.append(cast == drawn)
    assert np.mean(agree) > 0.93


def test_close_discs_become_one_blob_between_them() -> None:
    one = sequence("hard")
    pairs = 0
    for k, detections in one.received():
        for row in np.flatnonzero(one.other[k] >= 0):
            a, b = one.pixel_px[k, [one.owner[k][row], one.other[k][row]]]
            assert np.linalg.norm(a - b) < 14.0
            assert np.linalg.norm(detections.pixel_px[row] - 0.5 * (a + b)) < 14.0
            pairs += 1
    assert pairs > 10


def test_two_cameras_share_clock_and_hand_and_see_both_sides_of_a_grasp() -> None:
    one = point_sequence("hard", 2, 150, exercise="cylinder", views=FACING)
    assert one.view_visible.shape == (2, 150, 25)
    assert np.array_equal(one.view_visible[0], one.visible)
    only_behind = one.view_visible[1] & ~one.view_visible[0]
    assert only_behind.sum() > 100  # fingertips that have turned away from the first camera
    for k, detections in one.received():
        view = FACING[1]
        mine = (detections.view == 1) & (one.owner[k] >= 0) & (one.other[k] < 0)
        back = (detections.p_camera_m[mine] - view.p_tracking_camera_m) @ view.rotation_tracking_camera
        good = np.isfinite(back).all(axis=1)
        assert np.allclose(KINECT.project(back[good]), detections.pixel_px[mine][good])
        apart = np.linalg.norm(
            detections.pixel_px[mine] - one.view_pixel_px[1, k, one.owner[k][mine]], axis=1
        )
        assert np.all(apart < 8.0)


def test_the_same_instant_from_another_place_is_a_rigid_motion() -> None:
    scene = level_scene(LEVELS["easy"], "fist", 3.0, PROTOCOL, "left", np.random.default_rng(5))
    posed = scene.at(2.0)
    other = seen_from(posed, FACING[1])
    turn, origin = FACING[1].rotation_tracking_camera, FACING[1].p_tracking_camera_m
    assert other.landmarks_camera_m @ turn.T + origin == pytest.approx(posed.landmarks_camera_m)
    palm = (
        np.array([0.01, 0.02, 0.03]) @ other.rotation_camera_palm.T + other.p_camera_palm_m
    ) @ turn.T + origin
    assert palm == pytest.approx(
        np.array([0.01, 0.02, 0.03]) @ posed.rotation_camera_palm.T + posed.p_camera_palm_m
    )


def test_the_file_holds_what_the_command_reads(tmp_path: Path) -> None:
    one = sequence("hard")
    path = tmp_path / "detections.npz"
    write_detections_npz(one, path)
    with np.load(path, allow_pickle=False) as file:
        count = sum(len(detections) for detections in one.detections)
        assert [len(file[name]) for name in ("frame", "u_px", "v_px", "depth_m")] == [count] * 4
        assert file["frame_t_s"] == pytest.approx(1e-9 * one.t_ns)
        assert tuple(file["init_name"]) == PROTOCOL.names
        clicked = np.stack([file["init_u_px"], file["init_v_px"]], axis=1)
        assert np.abs(clicked - one.pixel_px[0]).max() < 6.0
        assert not np.isin(file["frame"], np.flatnonzero(one.dropped)).any()
        assert (file["fx"], file["height"]) == (525.0, 480)
    assert [entry.name for entry in tmp_path.iterdir()] == ["detections.npz"]


def test_bursts_lose_frames_in_a_row_and_never_in_the_first_second() -> None:
    level = replace(LEVELS["extreme"], dropped_share=0.0, burst_share=0.01)
    lost = dropped_frames(level, np.arange(9000) / 30.0, np.random.default_rng(0))
    starts = np.flatnonzero(np.diff(lost.astype(int)) == 1)
    assert not lost[:30].any()
    assert lost.sum() / len(starts) > 3.0


def test_refusals() -> None:
    with pytest.raises(Refused, match="one of easy"):
        level_of("impossible")
    with pytest.raises(Refused, match="one of fist"):
        point_sequence("easy", 0, 30, exercise="juggling")
