"""Boards before cameras whose truth is known: corners with noise, and drawn pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import pytest

from rehab_app.calibration.board import Board
from rehab_app.calibration.board_print import draw_board
from rehab_app.calibration.corners import Corners
from rehab_app.geometry.lens import Lens, camera_matrix
from rehab_app.geometry.pinhole import Intrinsics

TRUE = Intrinsics(531.0, 529.0, 327.0, 236.0, 640, 480)
BENT = Lens((-0.28, 0.09, 0.0012, -0.0008, 0.0))
BOARD = Board("chessboard", 9, 6, 0.025)


@dataclass(frozen=True)
class Scene:
    """A camera and what it sees of boards: poses, corners, pictures."""

    intrinsics: Intrinsics = TRUE
    lens: Lens = BENT
    board: Board = BOARD

    def pose(self, rng, *, tilt_rad=0.6, distance_m=(0.35, 0.6)):
        """A pose of the board somewhere in the picture: rotation vector, place."""
        turn = rng.uniform(-tilt_rad, tilt_rad, 3)
        z = rng.uniform(*distance_m)
        rotation = cv2.Rodrigues(turn)[0]
        middle = 0.5 * self.board.points_m[-1]
        away = np.array([rng.uniform(-0.22, 0.22) * z, rng.uniform(-0.15, 0.15) * z, z])
        return turn, away - rotation @ middle

    def project(self, turn, place):
        """Raw pixels of the board's corners."""
        matrix = camera_matrix(self.intrinsics)
        return cv2.projectPoints(self.board.points_m, turn, place, matrix, self.lens.vector)[0].reshape(-1, 2)

    def corners(self, rng, name, pose=None, noise_px=0.15):
        """Corners as a detector with noise would give them; those outside the picture are not seen."""
        turn, place = self.pose(rng) if pose is None else pose
        pixels = self.project(turn, place)
        size = np.array([self.intrinsics.width_px, self.intrinsics.height_px])
        inside = np.flatnonzero(((pixels > 0) & (pixels < size - 1)).all(axis=1))
        noisy = pixels[inside] + rng.normal(0.0, noise_px, (len(inside), 2))
        return Corners(name, tuple(int(side) for side in size), inside, noisy, 2.0)

    def many(self, rng, count=12, noise_px=0.15):
        return [self.corners(rng, f"image{number:02d}.png", None, noise_px) for number in range(count)]

    def picture(self, turn, place, fine=3):
        """The board drawn with covered parts of pixels, through the lens, on a grey wall, shape (H, W)."""
        page, dots_per_m, corner = _page(self.board)
        rays, shape = _rays(self.intrinsics, self.lens, fine)
        rotation = cv2.Rodrigues(np.asarray(turn, dtype=float))[0]
        # board coordinates of the rays' hits: rotation.T @ (s ray - place), with z = 0
        inside, origin = rays @ rotation, rotation.T @ np.asarray(place)
        on_board = (inside * (origin[2] / inside[:, 2])[:, None] - origin)[:, :2]
        where = ((on_board + corner) * dots_per_m - 0.5).astype(np.float32).reshape(*shape, 2)
        drawn = cv2.remap(page, where, None, cv2.INTER_LINEAR, borderValue=150)
        size = (self.intrinsics.width_px, self.intrinsics.height_px)
        return cv2.resize(drawn, size, interpolation=cv2.INTER_AREA)


@cache
def _rays(intrinsics, lens, fine):
    """Rays of ``fine`` x ``fine`` points in every raw pixel, and their numbers of rows and columns."""
    steps = (np.arange(fine) + 0.5) / fine - 0.5
    u = (np.arange(intrinsics.width_px)[:, None] + steps).ravel()
    v = (np.arange(intrinsics.height_px)[:, None] + steps).ravel()
    raw = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    return intrinsics.lift(lens.undistorted(raw, intrinsics), np.ones(len(raw))), (len(v), len(u))


def _page(board):
    """The printed page as an image, its dots per metre, and the first inner corner on it."""
    dots_per_m = 6000
    drawing = draw_board(board)
    size = (round(drawing.height_m * dots_per_m), round(drawing.width_m * dots_per_m))
    page = np.full(size, 235, dtype=np.uint8)
    for x, y, width, height in drawing.boxes_m:
        rows = slice(round(y * dots_per_m), round((y + height) * dots_per_m))
        page[rows, round(x * dots_per_m) : round((x + width) * dots_per_m)] = 20
    return page, dots_per_m, np.array(drawing.boxes_m[0][:2]) + board.square_m


@pytest.fixture
def scene() -> Scene:
    return Scene()


@pytest.fixture
def make_scene() -> Callable[..., Scene]:
    return Scene


@pytest.fixture(scope="session")
def chessboards(shared_data):
    """What is found in the left and in the right pictures of the stereo recording."""
    from rehab_app.calibration.pictures import look_for, pictures

    folder = shared_data / "chessboard_stereo"
    return [look_for(BOARD, pictures([str(folder / f"{side}*.jpg")])) for side in ("left", "right")]
