"""Blobs: connected pixels that are bluer than what surrounds them, with their sub-pixel centre and shape."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.contrast import Float32
from sessions.records.fields import Float64, Int64


@dataclass(frozen=True, slots=True)
class Blobs:
    """Blobs of one image.

    Attributes:
        centre_px: Weighted centres u v, shape (B, 2).
        axes_px: Half axes of the ellipse with the same second moments, longer first, shape (B, 2).
        area_px: Number of pixels, shape (B,).
        box_px: First u, first v, width, height, shape (B, 4).
        labels: Blob of each pixel counted from 1, 0 is none, shape (H, W).
        number: Label of each blob, shape (B,).
    """

    centre_px: Float64
    axes_px: Float64
    area_px: Float64
    box_px: Int64
    labels: NDArray[np.int32]
    number: Int64


def find_blobs(
    response: Float32, weight: Float32, threshold: float, area_px: tuple[float, float], limit: int = 400
) -> Blobs:
    """Connected parts of ``response`` above a threshold.

    Args:
        response: Contrast that decides what belongs to a blob, shape (H, W).
        weight: Non-negative weight of each pixel in the centre, shape (H, W).
        threshold: Lowest response in a blob.
        area_px: Smallest and largest area kept.
        limit: Most blobs kept (the largest), so that a bad picture costs a bounded time.
    """
    mask = (response > threshold).astype(np.uint8)
    count, labels, table, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    stats = np.asarray(table, np.int64)
    area = stats[:, cv2.CC_STAT_AREA]
    kept = np.flatnonzero((area >= area_px[0]) & (area <= area_px[1]))
    kept = kept[kept != 0]
    if len(kept) > limit:
        kept = np.sort(kept[np.argsort(-area[kept], kind="stable")[:limit]])
    centre, axes = _moments(np.asarray(labels, np.int32), weight, int(count), kept)
    return Blobs(
        centre, axes, area[kept].astype(np.float64), stats[kept, :4], np.asarray(labels, np.int32), kept
    )


def _moments(labels: NDArray[np.int32], weight: Float32, count: int, kept: Int64) -> tuple[Float64, Float64]:
    """Weighted centres (B, 2) and half axes (B, 2) of the kept labels."""
    rows, columns = np.nonzero(labels)
    label = labels[rows, columns]
    mass = np.maximum(weight[rows, columns].astype(np.float64), 1e-6)

    u_px, v_px = columns.astype(np.float64), rows.astype(np.float64)

    def total(values: Float64) -> Float64:
        return np.bincount(label, values, count)[kept].astype(np.float64)

    whole = total(mass)
    u, v = total(mass * u_px) / whole, total(mass * v_px) / whole
    uu = total(mass * u_px * u_px) / whole - u * u
    vv = total(mass * v_px * v_px) / whole - v * v
    uv = total(mass * u_px * v_px) / whole - u * v
    mean, spread = 0.5 * (uu + vv), np.sqrt(0.25 * (uu - vv) ** 2 + uv**2)
    squares = np.stack([mean + spread, np.maximum(mean - spread, 0.0)], axis=1)
    return np.stack([u, v], axis=1), 2.0 * np.sqrt(squares)
