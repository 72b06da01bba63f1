from __future__ import annotations

import cv2
import numpy as np
import pytest

from rehab_app.calibration.board import Board
from rehab_app.calibration.corners import Corners, Rejected, find_board
from rehab_app.geometry.lens import STRAIGHT
from rehab_app.geometry.pinhole import Intrinsics

CHARUCO = Board("charuco", 7, 5, 0.03, 0.0225, "4x4_50")
POSE = ((0.3, -0.4, 0.1), (-0.11, -0.06, 0.42))


@pytest.mark.parametrize(
    "board", [Board("chessboard", 9, 6, 0.025), CHARUCO, Board("charuco", 7, 6, 0.03, 0.02)]
)
def test_corners_are_found_to_about_a_tenth_of_a_pixel(make_scene, board):
    scene = make_scene(board=board)
    found = find_board(scene.picture(*POSE), board, "a.png")
    assert isinstance(found, Corners)
    assert len(found.index) == board.columns * board.rows
    off = found.pixel_px - scene.project(*map(np.array, POSE))[found.index]
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.12
    assert 1.5 < found.edge_px < 3.0


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_the_first_corner_does_not_depend_on_how_the_camera_is_turned(make_scene, turns):
    scene = make_scene(lens=STRAIGHT)
    image = scene.picture(*POSE)
    turned = np.ascontiguousarray(np.rot90(image, turns))
    first, second = (find_board(one, scene.board, "a").pixel_px for one in (image, turned))
    last = np.array(image.shape[::-1]) - 1
    for _ in range(turns):
        first = np.stack([first[:, 1], last[0] - first[:, 0]], axis=1)
        last = last[::-1]
    assert np.abs(first - second).max() < 0.1


def test_part_of_a_charuco_board_is_enough(make_scene):
    scene = make_scene(board=CHARUCO)
    image = scene.picture(*POSE)
    image[:, :300] = 128
    found = find_board(image, CHARUCO, "half.png")
    assert isinstance(found, Corners)
    assert 8 <= len(found.index) < CHARUCO.columns * CHARUCO.rows
    off = found.pixel_px - scene.project(*map(np.array, POSE))[found.index]
    assert np.linalg.norm(off, axis=1).max() < 0.5


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (np.zeros((480, 640), np.uint8), "no contrast"),
        (np.full((480, 640), 255, np.uint8), "no contrast"),
        (
            np.tile(np.arange(640, dtype=np.float64) * 0.3, (480, 1)).astype(np.uint8),
            "does not show the board",
        ),
        (np.zeros((0, 0), np.uint8), "no contrast"),
    ],
)
def test_pictures_without_a_board_say_why(scene, image, reason):
    found = find_board(image, scene.board, "x.png")
    assert isinstance(found, Rejected)
    assert reason in found.reason


def test_a_blurred_picture_is_left_out(scene):
    sharp = scene.picture((0.2, 0.1, 0.0), (-0.1, -0.06, 1.2))
    blurred = cv2.GaussianBlur(sharp, (0, 0), 2.2)
    found = find_board(blurred, scene.board, "x.png")
    assert isinstance(found, Rejected)
    assert "blurred" in found.reason or "does not show" in found.reason
    assert isinstance(find_board(sharp, scene.board, "x.png"), Corners)


def test_a_large_picture_is_searched_small_and_measured_large(make_scene):
    large = make_scene(intrinsics=Intrinsics(2124.0, 2116.0, 1309.5, 945.5, 2560, 1920))
    found = find_board(large.picture(*POSE, fine=1), large.board, "a.png")
    off = found.pixel_px - large.project(*map(np.array, POSE))
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.25
