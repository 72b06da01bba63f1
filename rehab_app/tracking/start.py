"""Where tracking begins: markers that a person pointed at in the first capture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.geometry.detections import Detections, joined
from rehab_app.tracking.tracked import Labels
from sessions.errors import Refused
from sessions.records.fields import Float64, Int64

NONE = -1
_REACH_PX = 12.0  # farther than this from any blob, a click stands for itself
_CLICK_STD_PX = 3.0
_FEWEST = 4


@dataclass(frozen=True, slots=True)
class LabelledCapture:
    """A capture whose markers have names.

    Attributes:
        detections: What was seen, and behind it the clicks that met no blob.
        row: Row of each marker, NONE where it was not named, shape (M,).
        seen: How many of the first rows are real detections.
    """

    detections: Detections
    row: Int64
    seen: int


def labelled(detections: Detections, labels: Labels, names: tuple[str, ...]) -> LabelledCapture:
    """Give the named pixels their detections.

    Args:
        detections: The first capture.
        labels: What a person pointed at.
        names: Names of the markers.

    Raises:
        Refused: See ``checked``.
    """
    labels = checked(labels, names)
    primary = np.flatnonzero(detections.view == 0)
    apart = np.linalg.norm(labels.pixel_px[:, None] - detections.pixel_px[primary], axis=2)
    row = np.full(len(names), NONE, dtype=np.int64)
    who = np.array([names.index(name) for name in labels.names])
    clicks, found = linear_sum_assignment(np.minimum(apart, 2.0 * _REACH_PX))
    near = apart[clicks, found] < _REACH_PX
    row[who[clicks[near]]] = primary[found[near]]
    bare = np.flatnonzero(row[who] == NONE)
    seen = len(detections)
    # rays of clicks are read off the rays of detections, which is only worth it where there are some
    if not bare.size or len(primary) < _FEWEST:
        return LabelledCapture(detections, row, seen)
    clicked = _clicked(detections.rows(primary), labels.pixel_px[bare])
    row[who[bare]] = seen + np.arange(len(bare))
    return LabelledCapture(joined([detections, clicked]), row, seen)


def _clicked(seen: Detections, pixel_px: Float64) -> Detections:
    """Clicks as rays without depth; rays of a pinhole are affine in the pixel, so those seen tell all."""
    flat = seen.ray_camera[:, :2] / seen.ray_camera[:, 2:]
    design = np.concatenate([seen.pixel_px, np.ones((len(seen), 1))], axis=1)
    slopes, *_ = np.linalg.lstsq(design, flat, rcond=None)
    ends = np.concatenate([pixel_px, np.ones((len(pixel_px), 1))], axis=1) @ slopes
    ray = np.concatenate([ends, np.ones((len(ends), 1))], axis=1)
    ray = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    count = len(ray)
    per_px = float(np.sqrt(np.abs(np.linalg.det(slopes[:2]))))
    return Detections(
        seen.t_capture_ns,
        pixel_px,
        np.full((count, 3), np.nan),
        np.full((count, 3, 3), np.nan),
        np.zeros(count),
        np.tile(seen.origin_camera_m[0], (count, 1)),
        ray,
        np.full(count, _CLICK_STD_PX * per_px),
        np.zeros(count, dtype=np.int64),
    )


def checked(labels: Labels, names: tuple[str, ...]) -> Labels:
    """The same labels without those that point nowhere (NaN).

    Args:
        labels: What a person pointed at.
        names: Names of the markers.

    Raises:
        Refused: A label names no marker of the protocol, or names one twice, or there are too few.
    """
    unknown = [name for name in labels.names if name not in names]
    if unknown:
        raise Refused("label", repr(unknown[0]), "one of " + ", ".join(names), "name markers of the protocol")
    if len(set(labels.names)) != len(labels.names):
        raise Refused("labels", "naming a marker twice", "each marker once", "remove one of them")
    pointed = np.flatnonzero(np.isfinite(labels.pixel_px).all(axis=1))
    if len(pointed) < _FEWEST:
        raise Refused("labels", f"{len(pointed)} markers", f"{_FEWEST} or more", "point at more markers")
    return Labels(tuple(labels.names[row] for row in pointed), labels.pixel_px[pointed])
