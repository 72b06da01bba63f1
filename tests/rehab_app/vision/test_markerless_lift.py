from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.cameras.virtual_hand import virtual_camera
from rehab_app.geometry.pinhole import KINECT
from rehab_app.geometry.view import PRIMARY
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.bare_hand import BareHandTracker, learn_bare_hand
from rehab_app.vision.markerless.landmarker import HandSighting
from rehab_app.vision.markerless.lift import guessed_hand, hidden, located, skin_depth
from sessions.records import JOINTS, LANDMARKS
from sessions.records.fields import Float64

NAMES = load_protocol("mediapipe21").names
ROWS = [LANDMARKS.index(name) for name in NAMES]
AWAY = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])


def open_hand(p_m: Float64) -> Float64:
    """The 21 joints of an open right hand in the camera frame, its palm towards the camera."""
    protocol = load_protocol("mediapipe21")
    model = MarkerModel(average_subject(protocol, "right"), protocol)
    local = model.positions(np.zeros(21))  # x palmar, y radial, z distal
    facing = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
    return local @ facing.T + p_m


def sighted(p_camera_m: Float64, scale: float = 1.0) -> HandSighting:
    world = scale * (p_camera_m - p_camera_m.mean(axis=0))
    return HandSighting(7, KINECT.project(p_camera_m), world, 0.98, 0.9)


def test_a_perfect_sighting_on_the_axis_is_put_where_it_is() -> None:
    truth = open_hand(np.array([0.0, 0.08, 0.6]))
    truth -= [truth[:, 0].mean(), 0.0, 0.0]
    truth[:, :2] -= (truth[:, :2] / truth[:, 2:]).mean(axis=0) * truth[:, 2:]
    found = guessed_hand(sighted(truth), KINECT)
    np.testing.assert_allclose(found, truth, atol=1e-4)


def test_a_hand_beside_the_axis_keeps_its_shape_and_covers_its_pixels() -> None:
    truth = open_hand(np.array([0.22, 0.1, 0.7]))
    found = guessed_hand(sighted(truth), KINECT)
    apart = np.linalg.norm(found[:, None] - found[None], axis=2)
    np.testing.assert_allclose(apart, np.linalg.norm(truth[:, None] - truth[None], axis=2), atol=1e-9)
    assert np.linalg.norm(KINECT.project(found) - KINECT.project(truth), axis=1).max() < 12.0


@pytest.mark.parametrize("scale", [0.85, 1.0, 1.2])
def test_depth_gives_the_true_scale_whatever_the_network_guessed(scale: float) -> None:
    truth = open_hand(np.array([0.0, 0.08, 0.6]))
    depth = np.full((480, 640), 0.6 - 0.009, np.float32)  # a flat hand's skin
    found = located(sighted(truth, scale), depth, KINECT)
    assert np.median(np.linalg.norm(found.p_camera_m - truth, axis=1)) < 0.01
    assert (found.similarity > 0.9).all()


def test_a_fingertip_behind_another_finger_is_a_guess() -> None:
    truth = open_hand(np.array([0.0, 0.08, 0.6]))
    tip, over = NAMES.index("ring_tip"), NAMES.index("middle_pip")
    truth[tip] = truth[over] + [0.0, 0.004, 0.03]
    behind = hidden(KINECT.project(truth), truth[:, 2], KINECT)
    assert behind[tip]
    assert not behind[NAMES.index("index_tip")]
    found = located(sighted(truth), np.full((480, 640), 0.59, np.float32), KINECT)
    assert found.similarity[tip] < 0.45 < found.similarity[over]
    assert found.covariance_m2[tip, 2, 2] > 4 * found.covariance_m2[over, 2, 2]


def test_depth_of_something_else_is_not_believed() -> None:
    truth = open_hand(np.array([0.0, 0.08, 0.6]))
    depth = np.full((480, 640), 0.591, np.float32)
    u, v = np.rint(KINECT.project(truth)[8]).astype(int)
    depth[v - 6 : v + 7, u - 6 : u + 7] = 1.4  # the wall beside the fingertip
    found = located(sighted(truth), depth, KINECT)
    assert abs(found.p_camera_m[8, 2] - truth[8, 2]) < 0.02
    assert found.covariance_m2[8, 2, 2] > 4 * found.covariance_m2[12, 2, 2]


def test_holes_and_the_world_beyond_the_edge_have_no_depth() -> None:
    pixel = np.array([[10.0, 10.0], [-5.0, 20.0], [30.0, 30.0]])
    depth = np.full((40, 60), np.nan, np.float32)
    depth[28:33, 28:33] = 0.5
    found = skin_depth(depth, pixel, np.full(3, 0.5), KINECT)
    np.testing.assert_array_equal(np.isfinite(found), [False, False, True])


def test_without_any_depth_in_the_image_all_is_a_guess() -> None:
    truth = open_hand(np.array([0.0, 0.08, 0.6]))
    empty = located(sighted(truth), np.zeros((480, 640), np.float32), KINECT)
    assert np.isfinite(empty.p_camera_m).all()
    assert (empty.similarity < 0.45).all()
    assert (located(sighted(truth), None, KINECT).similarity > 0.9).all()  # of a camera without depth


def test_a_second_camera_speaks_in_the_frame_of_the_first() -> None:
    truth = open_hand(np.array([0.0, 0.08, 0.6]))
    view = replace(PRIMARY, index=1, rotation_tracking_camera=AWAY, p_tracking_camera_m=np.array([0, 0, 1.2]))
    here, there = located(sighted(truth), None, KINECT), located(sighted(truth), None, KINECT, view)
    np.testing.assert_allclose(there.p_camera_m, here.p_camera_m @ AWAY.T + [0, 0, 1.2])
    assert (there.view == 1).all()


def test_depth_makes_joints_of_a_closing_hand_better() -> None:
    """Landmarks as wrong as a network's along the line of sight, before a rendered hand's depth image."""
    camera = virtual_camera("open_close", "right", 4.0, load_protocol("fingertips5"), seed=3)
    rng = np.random.default_rng(5)
    bias = rng.standard_normal((21, 3)) * [0.004, 0.004, 0.008]
    sightings, truth = [], []
    with camera:
        for index in range(0, 120, 4):
            frame, true = camera.frame(index), camera.truth(index / 30)
            p_m = true.landmarks_camera_m[ROWS]
            world = (
                1.1 * (p_m - p_m.mean(axis=0)) + bias + rng.standard_normal((21, 3)) * [0.002, 0.002, 0.008]
            )
            pixel = camera.intrinsics.project(p_m) + 1.5 * rng.standard_normal((21, 2))
            sightings.append((HandSighting(frame.t_capture_ns, pixel, world, 0.98, 0.9), frame))
            truth.append(true.joints_rad)
    pip = [JOINTS.index(f"{finger}_pip") for finger in ("index", "middle", "ring", "little")]
    rms_deg = {}
    for metric in (True, False):
        seen = [located(one, frame.depth_m if metric else None, KINECT) for one, frame in sightings]
        tracker = BareHandTracker(
            "right", metric=metric, subject=learn_bare_hand(seen, "right", metric=metric)
        )
        joints = np.array([tracker.observe(one)[0].pose.joints_rad for one in seen])
        rms_deg[metric] = np.rad2deg(np.sqrt(((joints - np.array(truth))[:, pip] ** 2).mean()))
        if metric:
            assert tracker.subject is not None
            assert tracker.subject.geometry.length_m == pytest.approx(0.185, rel=0.06)
    assert rms_deg[True] < 7.0
    assert rms_deg[True] < 0.6 * rms_deg[False]
