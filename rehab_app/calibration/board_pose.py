"""Where a board stands before a calibrated camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.corners import Corners
from rehab_app.geometry.lens import Lens, camera_matrix
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class BoardPose:
    """``T_camera_board`` as a rotation vector and a translation.

    Attributes:
        turn_rad: Rotation vector, shape (3,).
        p_camera_board_m: Origin of the board in the camera's frame, shape (3,).
        rms_px: Distance of found from predicted corners.
    """

    turn_rad: Float64
    p_camera_board_m: Float64
    rms_px: float


def board_pose(corners: Corners, board: Board, intrinsics: Intrinsics, lens: Lens) -> BoardPose | None:
    """The pose that explains the corners best; None where none puts the board before the camera.

    A flat board far away looks nearly the same under two tilts: both are refined, the better one is kept.
    """
    points = board.points_m[corners.index]
    pixels, matrix = corners.pixel_px, camera_matrix(intrinsics)
    try:
        solutions: Any = cv2.solvePnPGeneric(points, pixels, matrix, lens.vector, flags=cv2.SOLVEPNP_IPPE)
    except cv2.error:
        return None
    best: BoardPose | None = None
    for turn, place in zip(solutions[1], solutions[2], strict=True):
        refined: Any = cv2.solvePnPRefineLM(points, pixels, matrix, lens.vector, turn.copy(), place.copy())
        rotation, shift = (np.asarray(item, dtype=np.float64).reshape(3) for item in refined)
        off_px = projected(points, rotation, shift, intrinsics, lens) - pixels
        rms_px = float(np.sqrt((off_px**2).sum(axis=1).mean()))
        if np.isfinite(rms_px) and shift[2] > 0 and (best is None or rms_px < best.rms_px):
            best = BoardPose(rotation, shift, rms_px)
    return best


def projected(
    points_m: Float64, turn_rad: Float64, p_m: Float64, intrinsics: Intrinsics, lens: Lens
) -> Float64:
    """Raw pixels of points of the board (N, 3) under a pose, shape (N, 2)."""
    moved: Any = cv2.projectPoints(points_m, turn_rad, p_m, camera_matrix(intrinsics), lens.vector)[0]
    return np.asarray(moved, dtype=np.float64).reshape(-1, 2)


def matrix_of(turn_rad: Float64) -> Float64:
    """Rotation matrix of a rotation vector, shape (3, 3)."""
    turned: Any = cv2.Rodrigues(np.asarray(turn_rad, dtype=np.float64))[0]
    return np.asarray(turned, dtype=np.float64)


def vector_of(rotation: Float64) -> Float64:
    """Rotation vector of a rotation matrix, shape (3,)."""
    vector: Any = cv2.Rodrigues(rotation)[0]
    return np.asarray(vector, dtype=np.float64).reshape(3)
