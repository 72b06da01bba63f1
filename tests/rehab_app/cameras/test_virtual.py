"""The virtual camera against geometry that it does not share: projections, symmetry, seeds, hiding."""

from __future__ import annotations

import numpy as np
import pytest

from rehab_app.cameras import (
    CLEAN,
    HandScene,
    VirtualCamera,
    hand_scene,
    posture,
    scripted_motion,
    wear_markers,
)
from rehab_app.cameras.ray_cast import cast
from rehab_app.cameras.scripted_motion import MOTIONS, OPEN_S, ScriptedMotion
from rehab_app.cameras.skin import Capsules
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from rehab_app.hand.protocol import load_protocol
from robot_iface.kinematics import average_hand, forward
from robot_iface.types import JOINTS, LANDMARKS
from sessions.errors import Refused
from sessions.records import Side

SMALL = Intrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)


def scene(motion: str = "open_close", side: Side = "right", seed: int = 0) -> HandScene:
    geometry = average_hand(0.185, side)
    rng = np.random.default_rng(seed)
    return hand_scene(wear_markers(geometry, load_protocol("thesis25"), rng), scripted_motion(motion), rng)


def test_a_ball_is_drawn_where_geometry_puts_it() -> None:
    centre, radius = np.array([0.05, -0.03, 0.8]), 0.02
    ball = Capsules(centre[None], centre[None] + [[0.0, 0.0, 1e-6]], np.array([radius]))
    picture = cast(ball, np.array([0.0, 0.0, -1.0]), KINECT)
    rows, columns = np.nonzero(np.isfinite(picture.depth_m))
    pixel = np.stack([columns + picture.box[2], rows + picture.box[0]], axis=1).astype(float)
    points = KINECT.lift(pixel, picture.depth_m[rows, columns].astype(float))
    assert np.linalg.norm(points - centre, axis=1) == pytest.approx(radius, abs=1e-4)
    assert len(rows) == pytest.approx(np.pi * (radius * 525 / 0.8) ** 2, rel=0.03)


def test_a_capsule_lies_one_radius_around_its_axis() -> None:
    begin, end, radius = np.array([-0.04, 0.0, 0.7]), np.array([0.05, 0.03, 0.75]), 0.01
    picture = cast(Capsules(begin[None], end[None], np.array([radius])), np.array([0.0, 0.0, -1.0]), KINECT)
    rows, columns = np.nonzero(np.isfinite(picture.depth_m))
    pixel = np.stack([columns + picture.box[2], rows + picture.box[0]], axis=1).astype(float)
    points = KINECT.lift(pixel, picture.depth_m[rows, columns].astype(float))
    axis = end - begin
    share = np.clip((points - begin) @ axis / (axis @ axis), 0.0, 1.0)
    distance = np.linalg.norm(points - begin - share[:, None] * axis, axis=1)
    assert distance == pytest.approx(radius, abs=2e-4)


def test_nothing_before_the_camera_is_an_empty_picture() -> None:
    behind = Capsules(np.array([[0.0, 0.0, -1.0]]), np.array([[0.1, 0.0, -1.0]]), np.array([0.01]))
    assert cast(behind, np.array([0.0, 0.0, -1.0]), KINECT).depth_m.size == 0


@pytest.mark.parametrize("side", ["right", "left"])
def test_depth_at_a_marker_is_the_marker(side: Side) -> None:
    camera = VirtualCamera(scene(side=side), noise=CLEAN)
    truth, frame = camera.truth(0.5), camera.frame(15)
    whole = truth.seen > 0.9
    assert whole.sum() >= 24
    column, row = np.rint(truth.pixel_px[whole]).astype(int).T
    exact = truth.markers.p_camera_m[whole, 2]
    # half a pixel beside the centre of a disc slanted by up to 60 degrees lies up to 1.2 mm nearer or farther
    assert frame.depth_m[row, column] == pytest.approx(exact, abs=1.3e-3)
    blue = frame.colour_bgr[row, column].astype(int)
    assert (blue[:, 0] - blue[:, 2] > 70).all()


def test_landmarks_are_forward_kinematics_in_the_camera_frame() -> None:
    camera = VirtualCamera(scene())
    truth = camera.truth(2.4)
    palm = forward(camera.scene.worn.geometry, truth.joints_rad).landmarks_m
    expected = palm @ truth.rotation_camera_palm.T + truth.p_camera_palm_m
    assert truth.landmarks_camera_m == pytest.approx(expected)
    assert np.linalg.det(truth.rotation_camera_palm) == pytest.approx(1.0)
    height = truth.markers.p_camera_m - truth.landmarks_camera_m
    assert np.linalg.norm(height, axis=1) == pytest.approx(0.008, abs=0.004)


def test_thumb_is_on_the_side_that_it_belongs_to() -> None:
    thumb, little = LANDMARKS.index("thumb_tip"), LANDMARKS.index("little_tip")
    for side, sign in (("right", 1.0), ("left", -1.0)):
        pixel = VirtualCamera(scene(side=side)).truth(0.0).pixel_px
        assert sign * (pixel[little, 0] - pixel[thumb, 0]) > 60


def test_markers_ride_rigidly_on_their_bones() -> None:
    camera = VirtualCamera(scene("open_close"))
    tip, dip, pip = (LANDMARKS.index(f"middle_{part}") for part in ("tip", "dip", "pip"))
    open_hand, closed = camera.truth(0.0), camera.truth(OPEN_S + 1.3)
    bones = ((dip, pip), (tip, tip))
    for marker, landmark in bones:
        apart = [
            np.linalg.norm(t.markers.p_camera_m[marker] - t.landmarks_camera_m[landmark])
            for t in (open_hand, closed)
        ]
        assert apart[0] == pytest.approx(apart[1], abs=1e-9)


def test_a_marker_that_turns_away_is_hidden_and_not_drawn() -> None:
    camera = VirtualCamera(scene("open_close"), noise=CLEAN)
    tip = LANDMARKS.index("middle_tip")
    closed = camera.truth(OPEN_S + 1.3)
    assert closed.markers.facing()[tip] < 0.0
    assert closed.seen[tip] == 0.0
    assert camera.truth(0.0).seen[tip] > 0.95


def test_the_palm_shows_no_markers() -> None:
    one = scene()
    bent = posture(index_mcp_flexion=0.0, thumb_cmc_abduction=-5.0)
    motion = ScriptedMotion("hold", np.array([0.0, 1.0]), np.stack([bent, bent]))
    shown = HandScene(one.worn, motion, one.sway_phase_rad, one.p_camera_palm_m)
    turned = HandScene(one.worn, motion, one.sway_phase_rad, one.p_camera_palm_m, tilt_rad=np.pi)
    assert (VirtualCamera(shown).truth(0.0).seen > 0.5).sum() >= 24
    assert (VirtualCamera(turned).truth(0.0).seen == 0.0).all()  # the palm shows, the backs do not


def test_same_seed_same_frames_other_seed_others() -> None:
    one, same, other = (VirtualCamera(scene(), seed=seed).frame(7) for seed in (4, 4, 5))
    assert np.array_equal(one.colour_bgr, same.colour_bgr)
    assert np.array_equal(one.depth_m, same.depth_m)
    assert not np.array_equal(one.depth_m, other.depth_m)


def test_depth_noise_has_the_stated_size_and_holes() -> None:
    clean = VirtualCamera(scene(), noise=CLEAN).frame(3).depth_m
    noisy = VirtualCamera(scene(), seed=1).frame(3).depth_m
    on_hand = (clean < 1.0) & (noisy > 0.0)
    expected = 0.0012 * (clean[on_hand] / 0.7) ** 2
    assert np.std((noisy - clean)[on_hand] / expected) == pytest.approx(1.0, abs=0.2)
    inside = clean < 1.0
    assert 0.005 < np.mean(noisy[inside] == 0.0) < 0.4  # edges of thin fingers are much of a hand


def test_the_first_second_is_open_and_still() -> None:
    for name in MOTIONS:
        motion = scripted_motion(name)
        assert np.ptp(motion.joints_at(np.linspace(0.0, 1.0, 11)), axis=0).max() == 0.0
    truths = [VirtualCamera(scene()).truth(t).p_camera_palm_m for t in (0.0, 1.0)]
    assert np.array_equal(*truths)


def test_index_pip_flexes_by_the_stated_angle_and_nothing_else_but_its_tendon() -> None:
    motion = scripted_motion("index_pip", angle_deg=40.0)
    joints = motion.joints_at(np.linspace(0.0, motion.duration_s, 2000))
    span = np.rad2deg(np.ptp(joints, axis=0))
    assert span[JOINTS.index("index_pip")] == pytest.approx(40.0)
    assert span[JOINTS.index("index_dip")] == pytest.approx(80.0 / 3.0)
    assert np.count_nonzero(span) == 2


def test_minimum_jerk_peak_speed() -> None:
    zero, one = np.zeros(21), np.ones(21)
    motion = ScriptedMotion("step", np.array([0.0, 2.0]), np.stack([zero, one]))
    angle = motion.joints_at(np.linspace(0.0, 2.0, 4001))[:, 0]
    assert np.max(np.diff(angle)) / (2.0 / 4000) == pytest.approx(1.875 / 2.0, rel=1e-5)


def test_refusals_name_what_is_wrong() -> None:
    with pytest.raises(Refused, match="one of still"):
        scripted_motion("juggling")
    with pytest.raises(Refused, match="cycle period"):
        scripted_motion("tapping", period_s=0.0)
    with pytest.raises(Refused, match="joint"):
        posture(index_knuckle=3.0)
    with pytest.raises(Refused, match="rising"):
        ScriptedMotion("bad", np.array([0.0, 0.0]), np.zeros((2, 21)))
    with pytest.raises(Refused, match="frame rate"):
        VirtualCamera(scene(), rate_hz=0.0)


def test_a_small_image_holds_the_same_hand() -> None:
    frame = VirtualCamera(scene(), intrinsics=SMALL).frame(0)
    assert frame.colour_bgr.shape == (240, 320, 3)
    assert (frame.depth_m[frame.depth_m > 0] < 0.9).sum() > 2000
