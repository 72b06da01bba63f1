"""Names for the markers of an open hand: the protocol's layout laid over what was seen.

Shapes of an open hand (thumb in or out, fingers together or apart) are laid over the detections from many
starting rotations; assignment and similarity transform alternate until they agree; the best agreement wins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.geometry.detections import Detections
from sessions.records.fields import Float64, Int64

_STARTS = 16
_COARSE_ROUNDS = 3  # all starts get these; the most promising ones are then settled
_ROUNDS = 12
_PROMISING = 8
_SCALE = (0.7, 1.4)
NONE = -1


@dataclass(frozen=True, slots=True)
class Labelling:
    """Which detection carries which name.

    Attributes:
        detection: Row of the detection of each marker, NONE where there is none, shape (M,).
        residual_m: Root of the mean squared distance between shape and detections.
        shape: Which of the shapes it was.
    """

    detection: Int64
    residual_m: float
    shape: int


def label_open_hand(
    p_camera_m: Float64,
    shapes_palm_m: Float64,
    *,
    gate_m: float = 0.03,
    missing: int = 2,
    scale: tuple[float, float] = _SCALE,
    rotation: Float64 | None = None,
) -> Labelling | None:
    """Lay open hands over detections.

    Args:
        p_camera_m: Detections, shape (D, 3).
        shapes_palm_m: Marker places of some open hands of this side, shape (S, M, 3); -x points out of the
            back of the hand, which is taken to face the camera.
        gate_m: Farthest that a detection may lie from its marker's place.
        missing: Most markers that may lack a detection.
        scale: Smallest and largest factor on the shapes' size.
        rotation: Palm to camera, roughly, shape (3, 3); only that is tried then.

    Returns:
        The best labelling, or None where no shape fits.
    """
    count = shapes_palm_m.shape[1]
    if len(p_camera_m) < max(count - missing, 4):
        return None
    if rotation is None:
        starts = [(k, turn) for k, shape in enumerate(shapes_palm_m) for turn in _starts(p_camera_m, shape)]
    else:
        starts = [(k, rotation) for k in range(len(shapes_palm_m))]

    def settle(start: tuple[int, Float64], rounds: int) -> tuple[float, Int64]:
        return _settle(p_camera_m, shapes_palm_m[start[0]], start[1], gate_m, rounds, scale)

    coarse = [settle(start, _COARSE_ROUNDS)[0] for start in starts]
    promising = np.argsort(coarse, kind="stable")[:_PROMISING]
    settled = [settle(starts[index], _ROUNDS) for index in promising]
    best = int(np.argmin([one[0] for one in settled]))
    score, match = settled[best]
    matched = match != NONE
    if int(matched.sum()) < max(count - missing, 4):
        return None
    lost = (~matched).sum() * gate_m**2
    residual_m = float(np.sqrt(max(score * count - lost, 0.0) / matched.sum()))
    return Labelling(match, residual_m, starts[promising[best]][0])


def placed_points(detections: Detections, usual_m: float = 0.7) -> Float64:
    """A point for every detection, (D, 3): without depth at the others' median range, or a usual one."""
    apart = detections.p_camera_m - detections.origin_camera_m
    range_m = np.linalg.norm(apart, axis=1)
    known = np.isfinite(range_m)
    middle_m = float(np.median(range_m[known])) if bool(known.any()) else usual_m
    on_ray = detections.origin_camera_m + middle_m * detections.ray_camera
    return np.where(known[:, None], detections.p_camera_m, on_ray)


def _starts(points: Float64, shape: Float64) -> list[Float64]:
    """Rotations that lay the shape's plane on that of the detections, back to the camera, turned all ways."""
    toward = -points.mean(axis=0)
    seen, known = _plane(points, toward), _plane(shape, np.array([-1.0, 0.0, 0.0]))
    rotations: list[Float64] = []
    for angle in np.linspace(0.0, 2.0 * np.pi, _STARTS, endpoint=False):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        rotations.append(seen @ turn @ known.T)
    return rotations


def _plane(points: Float64, out: Float64) -> Float64:
    """Right-handed axes as columns whose third is the normal on the side of ``out``, shape (3, 3)."""
    _, _, axes = np.linalg.svd(points - np.median(points, axis=0))
    normal = axes[2] if axes[2] @ out > 0 else -axes[2]
    return np.stack([axes[0], np.cross(normal, axes[0]), normal], axis=1)


def _settle(
    points: Float64,
    shape: Float64,
    rotation: Float64,
    gate_m: float,
    rounds: int,
    bounds: tuple[float, float],
) -> tuple[float, Int64]:
    """Alternate assignment and similarity transform from one start; mean squared (gated) distance, match."""
    spread = np.sqrt(points.var(axis=0).sum() / shape.var(axis=0).sum())
    scale = float(np.clip(spread, *bounds))
    shift = np.median(points, axis=0) - scale * rotation @ np.median(shape, axis=0)
    gate = 3.0 * gate_m
    match, square = np.full(len(shape), NONE, dtype=np.int64), np.full(len(shape), np.inf)
    for _ in range(rounds):
        placed = scale * shape @ rotation.T + shift
        before, (match, square) = match, _assign(points, placed, gate)
        if gate == gate_m and bool((before == match).all()):
            break
        found = match != NONE
        if found.sum() < 4:
            return float("inf"), match
        scale, rotation, shift = _similarity(shape[found], points[match[found]], bounds)
        gate = max(gate_m, 0.6 * gate)
    return float(square.mean()), match


def _assign(points: Float64, placed: Float64, gate_m: float) -> tuple[Int64, Float64]:
    """One detection for each marker at most; matches (M,) and squared distances, gated, (M,)."""
    square = ((placed[:, None] - points) ** 2).sum(axis=2)
    cost = np.minimum(square, gate_m**2)
    rows, columns = linear_sum_assignment(cost)
    match = np.full(len(placed), NONE, dtype=np.int64)
    kept = square[rows, columns] < gate_m**2
    match[rows[kept]] = columns[kept]
    paid = np.full(len(placed), gate_m**2)
    paid[rows] = cost[rows, columns]
    return match, paid


def _similarity(
    source: Float64, target: Float64, bounds: tuple[float, float]
) -> tuple[float, Float64, Float64]:
    """Scale, rotation and shift that carry source points (N, 3) to target points in the least squares.

    Umeyama (1991), doi 10.1109/34.88573.
    """
    middle_s, middle_t = source.mean(axis=0), target.mean(axis=0)
    u, d, vt = np.linalg.svd((target - middle_t).T @ (source - middle_s))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = (u * sign) @ vt
    scale = float((d * sign).sum() / max(((source - middle_s) ** 2).sum(), 1e-12))
    scale = float(np.clip(scale, *bounds))
    return scale, rotation, middle_t - scale * rotation @ middle_s
