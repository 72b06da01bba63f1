"""Focal lengths, principal point and lens of a camera from images of a board (Zhang 2000, by OpenCV)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.corners import Corners, Rejected
from rehab_app.calibration.plausible import check_intrinsics
from rehab_app.calibration.selection import coverage, one_size, select
from rehab_app.calibration.verdict import INTRINSICS_BOUNDS, Verdict, judge
from rehab_app.errors import Refused
from rehab_app.geometry.lens import Lens
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

FEWEST = 3
"""Images below which focal lengths, principal point and lens cannot be told apart."""
_OUTLIER_FACTOR = 3.0  # times the median residual of the images ...
_OUTLIER_PX = 0.5  # ... and this much at 640 px width: then the image is not like the others
_NO_LENS = (
    cv2.CALIB_FIX_K1
    | cv2.CALIB_FIX_K2
    | cv2.CALIB_FIX_K3
    | cv2.CALIB_ZERO_TANGENT_DIST
    | cv2.CALIB_FIX_TANGENT_DIST
)
# From the simplest lens to the richest: what is held, how many coefficients are free.
_MODELS: tuple[tuple[str, int, int], ...] = (
    ("none", _NO_LENS, 0),
    ("k1", cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST, 1),
    ("k1 k2", cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST, 2),
    ("k1 k2 p1 p2", cv2.CALIB_FIX_K3, 4),
    ("k1 k2 p1 p2 k3", 0, 5),
)


@dataclass(frozen=True, slots=True)
class FittedView:
    """One image after the fit.

    Attributes:
        source: Name of the image.
        rms_px: Distance of found from predicted corners, rms.
        tilt_rad: Angle between the board's normal and the optical axis.
    """

    source: str
    rms_px: float
    tilt_rad: float


@dataclass(frozen=True, slots=True)
class IntrinsicsFit:
    """A calibrated camera, and how well.

    Attributes:
        intrinsics: Pinhole camera after the lens is removed.
        intrinsics_std_px: Standard deviations of fx fy cx cy, shape (4,).
        lens: Distortion k1 k2 p1 p2 k3; those that the images do not support are 0.
        lens_std: Their standard deviations, 0 where held, shape (5,).
        model: Which coefficients were free.
        rms_px: Distance of found from predicted corners over all images.
        views: The images used.
        rejected: The others, with reasons.
        coverage: Share of the image in which corners were seen.
        verdict: What it is worth.
    """

    intrinsics: Intrinsics
    intrinsics_std_px: Float64
    lens: Lens
    lens_std: Float64
    model: str
    rms_px: float
    views: tuple[FittedView, ...]
    rejected: tuple[Rejected, ...]
    coverage: float
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class _Solved:
    model: str
    free: int
    rms_px: float
    matrix: Float64
    lens: Float64
    turns: Float64
    std: Float64
    per_view_px: Float64

    def information(self, values: int) -> float:
        """Akaike's criterion: what a richer lens gains must pay for its coefficients.

        Stricter ones hold back small coefficients that are there, and what those did is then done by the
        principal point, beyond its stated uncertainty.
        """
        return float(values * np.log(max(self.rms_px, 1e-9) ** 2) + 2.0 * self.free)


def calibrate_intrinsics(seen: Sequence[Corners | Rejected], board: Board) -> IntrinsicsFit:
    """Calibrate one camera; images that do not fit the others are left out, with the reason.

    Args:
        seen: What ``find_board`` said of every image, in any order.
        board: The board.

    Raises:
        Refused: Fewer than 3 images show the board, they differ in size, or they tell nothing of the lens.
    """
    found = [item for item in seen if isinstance(item, Corners)]
    rejected = [item for item in seen if isinstance(item, Rejected)]
    _enough(found, rejected)
    size_px = one_size(found)
    used, twins = select(found, board)
    rejected += twins
    _enough(used, rejected)
    solved = _best_model(used, board, size_px)
    bad = _outlier(solved.per_view_px, size_px[0])
    while bad is not None and len(used) > FEWEST:
        residual_px = float(solved.per_view_px[bad])
        rejected.append(
            Rejected(used[bad].source, f"does not fit the others (corners {residual_px:.2f} px off)")
        )
        used = [item for row, item in enumerate(used) if row != bad]
        solved = _best_model(used, board, size_px)
        bad = _outlier(solved.per_view_px, size_px[0])
    return _told(solved, used, rejected, size_px)


def _enough(found: Sequence[Corners], rejected: Sequence[Rejected]) -> None:
    if len(found) >= FEWEST:
        return
    example = f"; {rejected[0].source} {rejected[0].reason}" if rejected else ""
    raise Refused(
        "number of images that show the board from different sides",
        f"{len(found)} of {len(found) + len(rejected)}{example}",
        f"{FEWEST} or more (10 to 20 are good)",
        "check the board's size and take more images",
    )


def _outlier(per_view_px: Float64, width_px: int) -> int | None:
    """The worst image, where it is not like the others."""
    bound = max(_OUTLIER_FACTOR * float(np.median(per_view_px)), _OUTLIER_PX * max(1.0, width_px / 640))
    worst = int(np.argmax(per_view_px))
    return worst if per_view_px[worst] > bound else None


def _best_model(used: Sequence[Corners], board: Board, size_px: tuple[int, int]) -> _Solved:
    """The lens that the images support: every coefficient pays for itself, none folds the image."""
    values = 2 * sum(len(item.index) for item in used)
    solved = [_solve(used, board, size_px, *model) for model in _MODELS]
    known = [item for item in solved if item is not None]
    if not known:
        raise _degenerate()
    return min(known, key=lambda item: item.information(values))


def _solve(
    used: Sequence[Corners], board: Board, size_px: tuple[int, int], model: str, flags: int, free: int
) -> _Solved | None:
    points = board.points_m.astype(np.float32)
    objects = [points[item.index] for item in used]
    images = [item.pixel_px.astype(np.float32) for item in used]
    guess: Any = np.eye(3)
    try:
        rms, matrix, lens, turns, _, std, _, per_view = cv2.calibrateCameraExtended(
            objects, images, size_px, guess, np.zeros(5), flags=flags
        )
    except cv2.error:
        return None
    numbers = [np.asarray(item, dtype=np.float64) for item in (matrix, lens, turns, std, per_view)]
    if not np.isfinite(rms) or not all(np.isfinite(item).all() for item in numbers):
        return None
    camera, bent, rotations, spread, residual = numbers
    solved = _Solved(
        model,
        free,
        float(rms),
        camera,
        bent.reshape(-1)[:5],
        rotations.reshape(-1, 3),
        spread.reshape(-1)[:9],
        residual.reshape(-1),
    )
    return solved if _possible(solved, size_px) else None


def _possible(solved: _Solved, size_px: tuple[int, int]) -> bool:
    try:
        intrinsics = _intrinsics(solved, size_px)
        check_intrinsics(intrinsics)
        return not Lens(tuple(solved.lens)).folds(intrinsics)
    except Refused:
        return False


def _intrinsics(solved: _Solved, size_px: tuple[int, int]) -> Intrinsics:
    matrix = solved.matrix
    return Intrinsics(
        float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2]), *size_px
    )


def _degenerate() -> Refused:
    return Refused(
        "calibration from these images",
        "impossible (they tell nothing of the focal length)",
        "possible",
        "tilt the board by 20 to 45 degrees to different sides, fill the image with it, and check its size",
    )


def _told(
    solved: _Solved, used: Sequence[Corners], rejected: Sequence[Rejected], size_px: tuple[int, int]
) -> IntrinsicsFit:
    tilts = [float(np.arccos(abs(cv2.Rodrigues(turn)[0][2, 2]))) for turn in solved.turns]
    covered = coverage(used)
    figures = {
        "rms_share": solved.rms_px / max(1.0, size_px[0] / 640),
        "focal_share": float(max(solved.std[0] / solved.matrix[0, 0], solved.std[1] / solved.matrix[1, 1])),
        "views": float(len(used)),
        "coverage": covered,
        "tilt_rad": max(tilts),
    }
    views = [
        FittedView(item.source, float(residual), tilt)
        for item, residual, tilt in zip(used, solved.per_view_px, tilts, strict=True)
    ]
    return IntrinsicsFit(
        _intrinsics(solved, size_px),
        solved.std[:4],
        Lens(tuple(float(value) for value in solved.lens)),
        solved.std[4:9],
        solved.model,
        solved.rms_px,
        tuple(views),
        tuple(rejected),
        covered,
        judge(figures, INTRINSICS_BOUNDS),
    )
