"""Which images of the board to calibrate from: different ones, spread over place, distance and tilt."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.corners import Corners, Rejected
from rehab_app.errors import Refused
from sessions.records.fields import Float64, Int64

MOST = 40
"""Images beyond these add time, not knowledge."""
_SAME = 0.004  # share of the image's width by which a board must have moved to be another view
_CELLS = (8, 6)


def one_size(found: Sequence[Corners]) -> tuple[int, int]:
    """Width and height of all images, px.

    Raises:
        Refused: They differ.
    """
    sizes = {corners.size_px: corners for corners in reversed(found)}
    if len(sizes) > 1:
        second, first = list(sizes.values())[:: len(sizes) - 1]
        raise Refused(
            f"size of {second.source}",
            f"{second.size_px[0]} x {second.size_px[1]}",
            f"{first.size_px[0]} x {first.size_px[1]} like {first.source}",
            "use images of one camera at one resolution",
        )
    return found[0].size_px


def outline(corners: Corners, board: Board) -> Float64:
    """The four corners of the board's grid in the image by its homography, shape (4, 2), px."""
    points = board.points_m[:, :2]
    homography: Any = cv2.findHomography(points[corners.index], corners.pixel_px)[0]
    ends = points[[0, board.columns - 1, -1, -board.columns]]
    moved = np.column_stack([ends, np.ones(4)]) @ np.asarray(homography, dtype=np.float64).T
    return moved[:, :2] / moved[:, 2:]


def select(found: Sequence[Corners], board: Board, most: int = MOST) -> tuple[list[Corners], list[Rejected]]:
    """The sharper of images that are nearly the same, and of too many those that differ most.

    Args:
        found: Images in which the board was found, all of one size.
        board: The board.
        most: How many to keep at most.

    Returns:
        Those to use in their old order, and the others with the reason.
    """
    width_px = found[0].size_px[0]
    features = np.array([outline(corners, board).reshape(-1) for corners in found]) / width_px
    edges = np.array([corners.edge_px for corners in found])
    chosen = [int(np.argmin(edges))]
    twin = np.full(len(found), chosen[0])
    away = _distance(features, features[chosen[0]])
    while len(chosen) < most and away.max() >= _SAME:
        # among the farthest the sharper: a blurred image is worth less than its distance says
        following = int(np.argmax(away / edges))
        if away[following] < _SAME:
            following = int(np.argmax(away))
        chosen.append(following)
        nearer = _distance(features, features[following])
        twin = np.where(nearer < away, following, twin)
        away = np.minimum(away, nearer)
    left = sorted(set(range(len(found))) - set(chosen))
    rejected = [Rejected(found[i].source, _why(away[i], found[twin[i]].source)) for i in left]
    return [found[i] for i in sorted(chosen)], rejected


def coverage(found: Sequence[Corners]) -> float:
    """Share of the cells of an 8 x 6 grid over the image in which a corner was seen."""
    seen: set[tuple[int, int]] = set()
    for corners in found:
        cells: Int64 = np.floor(corners.pixel_px / np.array(corners.size_px) * _CELLS).astype(np.int64)
        seen.update((int(u), int(v)) for u, v in cells)
    return len(seen) / (_CELLS[0] * _CELLS[1])


def _distance(features: Float64, one: Float64) -> Float64:
    return np.sqrt(((features - one) ** 2).mean(axis=1))


def _why(away: float, twin: str) -> str:
    return f"shows the board as {twin} does" if away < _SAME else f"adds little beside {twin}"
