from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.calibration import CalibratedCamera, Rejected, calibrate_rig, views_of, world_from_board
from rehab_app.calibration.board import Board
from rehab_app.calibration.board_pose import matrix_of
from rehab_app.calibration.pictures import at_once
from rehab_app.calibration.rig_cameras import cameras_of, placed
from rehab_app.errors import Refused
from rehab_app.geometry.view import PRIMARY

POSE = (np.array([2.6, 0.2, -0.1]), np.array([-0.08, 0.05, 0.5]))


@pytest.fixture
def camera(scene):
    return CalibratedCamera(camera="webcam:0", intrinsics=scene.intrinsics, lens=scene.lens)


def test_the_camera_stands_where_it_stands(scene, camera):
    rng = np.random.default_rng(1)
    turn = np.array([0.5, 0.2, -0.1])
    seen = [scene.corners(rng, f"{n}.png", (turn, POSE[1])) for n in range(4)]
    fit = world_from_board(seen, scene.board, camera)
    rotation_camera_board = matrix_of(turn)
    # z of the world comes out of the board: half a turn about x
    true_rotation = np.diag([1.0, -1.0, -1.0]) @ rotation_camera_board.T
    assert np.abs(fit.placement.rotation_reference_camera - true_rotation).max() < 5 * fit.turn_std_rad
    away = fit.placement.p_reference_camera_m + true_rotation @ POSE[1]
    assert np.linalg.norm(away) < 0.003
    assert fit.placement.p_reference_camera_m[2] > 0.3
    assert fit.verdict.word == "good"
    # a point on the table, one square from the origin, is seen where it is
    p_world = np.array([scene.board.square_m, 0.0, 0.0])
    rotation, place = fit.placement.rotation_reference_camera, fit.placement.p_reference_camera_m
    pixel = camera.lens.distorted(
        camera.intrinsics.project(rotation.T @ (p_world - place))[None], camera.intrinsics
    )
    assert np.abs(pixel - scene.project(turn, POSE[1])[1]).max() < 0.3


def test_two_cameras_over_one_board_stand_beside_each_other(chessboards, scene):
    cameras = cameras_of(chessboards, scene.board, [], ["left", "right"])
    together = placed(
        calibrate_rig(at_once(chessboards), scene.board, [one.known for one in cameras]), cameras, scene.board
    )
    seen = [
        replace(camera, world=world_from_board(one[:1], scene.board, camera).placement)
        for camera, one in zip(cameras, chessboards, strict=True)
    ]
    by_rig, by_world = views_of(together)[1], views_of(seen)[1]
    assert np.abs(by_rig.p_tracking_camera_m - by_world.p_tracking_camera_m).max() < 0.002
    assert np.abs(by_rig.rotation_tracking_camera - by_world.rotation_tracking_camera).max() < 0.005
    with pytest.raises(Refused, match="calibrate stereo"):
        views_of([together[0], seen[1]])
    with pytest.raises(Refused, match="calibrate stereo"):
        views_of(cameras)
    assert views_of(cameras[:1]) == (PRIMARY,)


def test_bad_input_is_one_sentence(scene, make_scene, camera):
    rng = np.random.default_rng(2)
    turn = np.array([0.3, 0.2, 0.0])
    with pytest.raises(Refused, match="in none of the images"):
        world_from_board([Rejected("a.png", "has no contrast")], scene.board, camera)
    moved = [scene.corners(rng, f"{n}.png", (turn, POSE[1] + [0.02 * n, 0, 0])) for n in range(3)]
    with pytest.raises(Refused, match="moving by 20 mm"):
        world_from_board(moved, scene.board, camera)
    even = make_scene(board=Board("chessboard", 8, 6, 0.025))
    with pytest.raises(Refused, match="half a turn"):
        world_from_board([even.corners(rng, "a.png", (turn, POSE[1]))], even.board, camera)
