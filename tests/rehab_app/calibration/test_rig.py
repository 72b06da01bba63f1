from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from rehab_app.calibration import calibrate_intrinsics, calibrate_rig
from rehab_app.calibration.board import Board
from rehab_app.calibration.board_pose import matrix_of, vector_of
from rehab_app.calibration.pictures import at_once
from rehab_app.calibration.rig_cameras import cameras_of, placed
from rehab_app.calibration.rig_problem import Known
from rehab_app.errors import Refused
from rehab_app.geometry.lens import camera_matrix

# T_camera_tracking of three cameras; the third stands far round, as two that face each other would
PLACES = [
    (np.zeros(3), np.zeros(3)),
    (np.array([0.02, -0.5, 0.01]), np.array([0.21, 0.01, 0.05])),
    (np.array([-0.1, 0.6, 0.05]), np.array([-0.25, 0.02, 0.09])),
]


@pytest.fixture
def see(scene):
    """Corners of one board pose in some of the cameras."""

    def look(rng, name, cameras=(0, 1, 2), noise_px=0.15, of=scene):
        turn, place = of.pose(rng, tilt_rad=0.4)
        capture = {}
        for camera in cameras:
            rotation = matrix_of(PLACES[camera][0])
            own = vector_of(rotation @ matrix_of(turn)), rotation @ place + PLACES[camera][1]
            capture[camera] = of.corners(rng, f"{name}-{camera}", own, noise_px)
        return capture

    return look


def known(scene, count=3):
    return [Known(scene.intrinsics, scene.lens)] * count


def errors(fit):
    """Turns in rad and distances in m of the cameras from where they truly stand."""
    turns, away = [], []
    for view, (turn, place) in zip(fit.views, PLACES, strict=False):
        rotation = matrix_of(turn)
        turns.append(np.linalg.norm(vector_of(view.rotation_tracking_camera @ rotation)))
        away.append(np.linalg.norm(view.p_tracking_camera_m + rotation.T @ place))
    return np.array(turns), np.array(away)


def test_cameras_are_found_within_the_stated_uncertainty(scene, see):
    rng = np.random.default_rng(1)
    captures = [see(rng, f"{n}") for n in range(10)]
    fit = calibrate_rig(captures, scene.board, known(scene))
    turns, away = errors(fit)
    assert turns[0] == away[0] == 0.0
    assert (turns[1:] < 4 * fit.turn_std_rad[1:]).all()
    assert (away[1:] < 4 * fit.place_std_m[1:]).all()
    assert fit.place_std_m.max() < 0.001
    assert fit.rms_px == pytest.approx(0.15 * np.sqrt(2), rel=0.1)
    assert fit.verdict.word == "good"


def test_cameras_are_chained_through_those_that_share_the_board(scene, see):
    rng = np.random.default_rng(2)
    captures = [see(rng, f"{n}", (0, 1) if n % 2 else (1, 2)) for n in range(12)]
    fit = calibrate_rig(captures, scene.board, known(scene))
    turns, away = errors(fit)
    assert turns.max() < 0.004
    assert away.max() < 0.002
    assert [view.index for view in fit.views] == [0, 1, 2]


def test_a_board_that_may_be_counted_from_either_end(make_scene, see):
    scene = make_scene(board=Board("chessboard", 8, 6, 0.025))
    rng = np.random.default_rng(3)
    captures = []
    for number in range(10):
        capture = see(rng, f"{number}", of=scene, noise_px=0.1)
        if any(len(corners.index) < 48 for corners in capture.values()):
            continue
        turned = {camera for camera in capture if rng.random() < 0.5}
        captures.append(
            {
                camera: replace(corners, pixel_px=corners.pixel_px[::-1]) if camera in turned else corners
                for camera, corners in capture.items()
            }
        )
    assert len(captures) >= 4
    fit = calibrate_rig(captures, scene.board, known(scene))
    assert len(fit.used) == len(captures)
    turns, away = errors(fit)
    assert turns.max() < 0.004
    assert away.max() < 0.002


def test_an_instant_that_contradicts_the_others_is_left_out(scene, see):
    rng = np.random.default_rng(4)
    captures = [see(rng, f"{n}", (0, 1)) for n in range(8)]
    captures[3] = {0: captures[3][0], 1: captures[6][1]}
    fit = calibrate_rig(captures, scene.board, known(scene, 2))
    assert [item.source for item in fit.rejected] == ["3-0"]
    assert errors(fit)[1].max() < 0.002


def test_an_instant_that_is_a_little_off_is_left_out(scene, see):
    rng = np.random.default_rng(6)
    captures = [see(rng, f"{n}", (0, 1)) for n in range(8)]
    one = captures[5][1]
    captures[5] = {**captures[5], 1: replace(one, pixel_px=one.pixel_px + np.array([0.0, 4.0]))}
    fit = calibrate_rig(captures, scene.board, known(scene, 2))
    assert [item.source for item in fit.rejected] == ["5-0"]
    assert "does not fit the others" in fit.rejected[0].reason
    assert fit.rms_px < 0.25


def test_bad_input_is_one_sentence(scene, see):
    rng = np.random.default_rng(5)
    apart = [see(rng, f"{n}", (n % 2,)) for n in range(6)]
    with pytest.raises(Refused, match="camera 2 is never seen together"):
        calibrate_rig(apart, scene.board, known(scene, 2))
    with pytest.raises(Refused, match="number of cameras is 1"):
        calibrate_rig(apart, scene.board, known(scene, 1))
    seen = [[capture[0] for capture in apart[::2]], [capture[1] for capture in apart[1::2]]]
    with pytest.raises(Refused, match="different: name each with --id"):
        cameras_of([scene.many(rng), scene.many(rng)], scene.board, [], ["a", "a"])
    with pytest.raises(Refused, match="number of ids of the cameras is 1"):
        cameras_of(seen, scene.board, [], ["a"])


def test_the_real_pair_agrees_with_the_library(chessboards, scene):
    cameras = cameras_of(chessboards, scene.board, [], ["left", "right"])
    fit = calibrate_rig(at_once(chessboards), scene.board, [camera.known for camera in cameras])
    assert fit.rms_px <= 0.25
    assert fit.baseline_m() == pytest.approx(0.0832, abs=0.0005)
    assert len(fit.used) == 13
    points = [scene.board.points_m.astype(np.float32)] * 13
    pixels = [[corners.pixel_px.astype(np.float32) for corners in one] for one in chessboards]
    lenses = [part for one in cameras for part in (camera_matrix(one.intrinsics), one.lens.vector)]
    theirs = cv2.stereoCalibrate(points, *pixels, *lenses, (640, 480), flags=cv2.CALIB_FIX_INTRINSIC)
    assert fit.rms_px == pytest.approx(theirs[0], rel=1e-4)
    rotation = fit.views[1].rotation_tracking_camera.T
    assert np.abs(rotation - theirs[5]).max() < 1e-5
    assert np.abs(-rotation @ fit.views[1].p_tracking_camera_m - theirs[6].ravel()).max() < 1e-5
    left, right = placed(fit, cameras, scene.board)
    assert left.view().p_tracking_camera_m.tolist() == [0.0, 0.0, 0.0]
    assert right.placement.reference == "left"
    assert right.view(1).index == 1
    assert right.verdict == "good"
    assert right.rms_px == pytest.approx(calibrate_intrinsics(chessboards[1], scene.board).rms_px)
