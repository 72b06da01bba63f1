"""Recall, precision and centre error of a marker detector before the virtual camera, at a level."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.cameras import VirtualCamera, virtual_camera
from rehab_app.geometry.detections import Detections
from rehab_app.hand.protocol import load_protocol
from rehab_app.vision import Detector
from sessions.records.fields import Float64

_MATCH_PX = 4.0
_VISIBLE = (0.5, 0.2)  # least share of the disc in view, least cosine towards the camera: what must be found
_SEEN = 0.1  # share from which finding a marker is right, though it need not be found


@dataclass(frozen=True, slots=True)
class DetectionScore:
    """How well markers were found.

    Attributes:
        recall: Share of the visible markers that were found.
        precision: Share of the detections that are markers.
        centre_rms_px: Root mean square distance of found centres from the true ones.
        point_median_m: Median distance of found points from the true ones; NaN without depth.
        ms: Median processor time of a frame, ms.
    """

    recall: float
    precision: float
    centre_rms_px: float
    point_median_m: float
    ms: float


def detection_score(
    detector: Detector,
    level: str,
    seeds: Iterable[int],
    *,
    frames: Iterable[int] = range(0, 330, 11),
    window: bool = False,
    depth: bool = True,
) -> DetectionScore:
    """Score a detector over mixed exercises of several hands.

    Args:
        detector: What to score.
        level: Name of the level.
        seeds: One hand and sequence each.
        frames: Frames looked at in each.
        window: Look about the true hand only, as while tracking.
        depth: Show the depth image.
    """
    rows = [
        _frame(detector, camera, index, window=window, depth=depth)
        for camera in (_camera(level, seed) for seed in seeds)
        for index in frames
    ]
    visible, found, right, seen, ms = (np.array([row[k] for row in rows]) for k in range(5))
    pixel = np.concatenate([row[5] for row in rows])
    point = np.concatenate([row[6] for row in rows])
    return DetectionScore(
        recall=float(found.sum() / visible.sum()),
        precision=float(right.sum() / max(seen.sum(), 1)),
        centre_rms_px=float(np.sqrt((pixel**2).mean())),
        point_median_m=float(np.nanmedian(point)) if np.isfinite(point).any() else float("nan"),
        ms=float(np.median(ms)),
    )


def _camera(level: str, seed: int) -> VirtualCamera:
    side = "right" if seed % 2 else "left"
    return virtual_camera("mixed", side, 12.0, load_protocol("thesis25"), seed=seed, level=level)


Row = tuple[int, int, int, int, float, Float64, Float64]


def _frame(detector: Detector, camera: VirtualCamera, index: int, *, window: bool, depth: bool) -> Row:
    """Visible, found of them, right detections, all detections, ms, errors in px and in m."""
    frame, truth = camera.frame(index), camera.truth(index / camera.rate_hz)
    around = truth.markers.p_camera_m if window else None
    begin = time.thread_time()
    seen = detector.detect(
        frame.t_capture_ns, frame.colour_bgr, frame.depth_m if depth else None, frame.intrinsics, around
    )
    ms = 1e3 * (time.thread_time() - begin)
    must = (truth.seen >= _VISIBLE[0]) & (truth.markers.facing() > _VISIBLE[1])
    rows, columns = pairs(truth.pixel_px, truth.seen > _SEEN, must, seen)
    good = must[rows]
    pixel = np.linalg.norm(seen.pixel_px[columns] - truth.pixel_px[rows], axis=1)[good]
    point = np.linalg.norm(seen.p_camera_m[columns] - truth.markers.p_camera_m[rows], axis=1)[good]
    return int(must.sum()), int(good.sum()), len(rows), len(seen), ms, pixel, point


def pairs(
    pixel_px: Float64, seen: Float64, must: Float64, detections: Detections
) -> tuple[np.ndarray, np.ndarray]:
    """Markers and detections that belong together, at most one of each: rows of both."""
    apart = np.linalg.norm(pixel_px[:, None] - detections.pixel_px, axis=2)
    apart = np.where(seen[:, None], np.minimum(apart, 50.0), 50.0)
    rows, columns = linear_sum_assignment(apart - 1e-3 * must[:, None])
    near = apart[rows, columns] < _MATCH_PX
    return rows[near], columns[near]
