"""Finds a board in an image: its inner corners to a fraction of a pixel, or the reason why not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.calibration.board import Board, charuco_board
from sessions.records.fields import Float64, Int64

Grey: TypeAlias = NDArray[np.uint8]
FEWEST = 8
"""Corners of a partly seen board that still say something."""
_BLUR_SHARE = 0.33  # of the smallest distance between corners: wider edges run into each other
_SEARCHED_PX = 1280  # longer side of the image that is searched; corners are refined in the whole one
_QUICK = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
_FLAT_GREY = 12.0  # grey levels between black and white below which nothing can be told


@dataclass(frozen=True, slots=True)
class Corners:
    """The corners of a board in one image.

    Attributes:
        source: Name of the image.
        size_px: Width and height of the image.
        index: Which of the board's points was seen, shape (K,).
        pixel_px: Where, shape (K, 2).
        edge_px: Width of the edges between black and white, median; about 2 where the image is sharp.
    """

    source: str
    size_px: tuple[int, int]
    index: Int64
    pixel_px: Float64
    edge_px: float


@dataclass(frozen=True, slots=True)
class Rejected:
    """An image that was not used.

    Attributes:
        source: Name of the image.
        reason: Why, as the rest of a sentence that begins with its name.
    """

    source: str
    reason: str


def find_board(grey: Grey, board: Board, source: str) -> Corners | Rejected:
    """Look for the board in an image.

    Args:
        grey: Image, shape (H, W).
        board: What to look for; all of a chessboard must be seen, of a charuco board a part.
        source: Name of the image.
    """
    if int(grey.max(initial=0)) - int(grey.min(initial=255)) < _FLAT_GREY:
        return Rejected(source, "has no contrast (covered, black or over-exposed)")
    found = _charuco(grey, board) if board.kind == "charuco" else _chessboard(grey, board)
    if found is None:
        return Rejected(source, f"does not show the board ({board.columns} x {board.rows} inner corners)")
    index, rough_px = found
    spacing_px = _smallest_spacing(rough_px)
    pixel_px = _refined(grey, rough_px, _reach(board) * spacing_px)
    edge_px = _edge_width(grey, pixel_px, spacing_px)
    if edge_px > max(4.0, _BLUR_SHARE * spacing_px):
        return Rejected(source, f"is blurred (edges {edge_px:.1f} px wide, squares {spacing_px:.0f} px)")
    return Corners(source, (grey.shape[1], grey.shape[0]), index, pixel_px, edge_px)


def other_board(grey: Grey, board: Board) -> str:
    """A hint that the image shows a chessboard of nearly this size instead, empty where it does not."""
    if board.kind != "chessboard":
        return ""
    small, _ = _reduced(grey)
    for columns in range(board.columns + 2, max(board.columns - 3, 2), -1):
        for rows in range(board.rows + 2, max(board.rows - 3, 2), -1):
            quick = _QUICK | cv2.CALIB_CB_FAST_CHECK
            if cv2.findChessboardCorners(small, (columns, rows), flags=quick)[0]:
                return f", but one of {columns} x {rows}"
    return ""


def _chessboard(grey: Grey, board: Board) -> tuple[Int64, Float64] | None:
    """All corners, the first one beside a black corner square where the board tells them apart."""
    pattern = (board.columns, board.rows)
    small, scale = _reduced(grey)
    found: Any
    ok, found = cv2.findChessboardCorners(small, pattern, flags=_QUICK)
    if not ok:  # slower, but sees through blur and uneven light
        ok, found = cv2.findChessboardCornersSB(small, pattern, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not ok or found is None or len(found) != board.columns * board.rows:
        return None
    # pixel 0 is the centre of the first pixel in either image
    pixel_px = (np.asarray(found, dtype=np.float64).reshape(-1, 2) + 0.5) * scale - 0.5
    return np.arange(len(pixel_px)), _same_start(grey, board, pixel_px)


def _reduced(grey: Grey) -> tuple[Grey, Float64]:
    """An image small enough to be searched quickly, and how much larger the original is along u and v."""
    height, width = grey.shape
    share = min(1.0, _SEARCHED_PX / max(height, width))
    size = (round(share * width), round(share * height))
    scale = np.array([width / size[0], height / size[1]])
    if share == 1.0:
        return grey, scale
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), dtype=np.uint8), scale


def _same_start(grey: Grey, board: Board, pixel_px: Float64) -> Float64:
    """Corners in the order that is right-handed and, where that can be told, begins at a black square."""
    grid = pixel_px.reshape(board.rows, board.columns, 2)
    along, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if along[0] * down[1] - along[1] * down[0] < 0:  # seen as in a mirror: rows were counted upwards
        grid = grid[::-1]
    if board.one_way_up and _first_square(grey, grid) > _first_square(grey, grid[::-1, ::-1]):
        grid = grid[::-1, ::-1]
    return grid.reshape(-1, 2)


def _first_square(grey: Grey, grid: Float64) -> float:
    """Brightness of the first square within the grid, which is as bright as the board's own corner square."""
    centre = 0.5 * (grid[0, 0] + grid[1, 1])
    column, row = np.clip(np.rint(centre).astype(int), 0, np.array(grey.shape[::-1]) - 1)
    return float(np.median(grey[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]))


def _charuco(grey: Grey, board: Board) -> tuple[Int64, Float64] | None:
    corners: Any = None
    ids: Any = None
    for white_first in (False, True):
        detector = cv2.aruco.CharucoDetector(charuco_board(board, white_first=white_first))
        corners, ids, _, _ = detector.detectBoard(grey)
        if ids is not None and len(ids) >= FEWEST:
            break
    if ids is None or corners is None or len(ids) < FEWEST:
        return None
    index = np.asarray(ids, dtype=np.int64).reshape(-1)
    grid = np.stack([index % board.columns, index // board.columns])
    if min(len(np.unique(line)) for line in grid) < 2:  # all on one line: no plane
        return None
    return index, np.asarray(corners, dtype=np.float64).reshape(-1, 2)


def _smallest_spacing(pixel_px: Float64) -> float:
    """Median distance of a corner to its nearest neighbour, px."""
    away = np.linalg.norm(pixel_px[:, None] - pixel_px[None], axis=2)
    np.fill_diagonal(away, np.inf)
    return float(np.median(away.min(axis=1)))


def _reach(board: Board) -> float:
    """How far about a corner there is nothing but its own edges, as a share of a square."""
    if board.kind == "chessboard":
        return 0.25  # half a square is free; seen from the side, it shrinks
    return 0.45 * (1.0 - board.marker_m / board.square_m)


def _refined(grey: Grey, rough_px: Float64, reach_px: float) -> Float64:
    """Saddle points near the rough corners."""
    half = int(np.clip(reach_px, 2, 11))
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-4)
    start = np.ascontiguousarray(rough_px, dtype=np.float32).reshape(-1, 1, 2)
    refined: Any = cv2.cornerSubPix(grey, start, (half, half), (-1, -1), criteria)
    moved = refined.reshape(-1, 2).astype(np.float64)
    astray = np.linalg.norm(moved - rough_px, axis=1) > half
    return np.where(astray[:, None], rough_px, moved)


def _edge_width(grey: Grey, pixel_px: Float64, spacing_px: float) -> float:
    """Contrast over steepest slope around each corner, median, px."""
    half = int(np.clip(0.4 * spacing_px, 3, 15))
    image = grey.astype(np.float32)
    slope = np.hypot(cv2.Sobel(image, cv2.CV_32F, 1, 0) / 8.0, cv2.Sobel(image, cv2.CV_32F, 0, 1) / 8.0)
    widths: list[float] = []
    for column, row in np.rint(pixel_px).astype(int):
        part = (slice(max(row - half, 0), row + half + 1), slice(max(column - half, 0), column + half + 1))
        if image[part].size:
            widths.append(float(np.ptp(image[part]) / max(float(slope[part].max()), 1e-3)))
    return float(np.median(widths))
