"""Blobs: connected pixels that stand out in colour, with their sub-pixel centre and shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.vision.components import Parts, connected_parts, joined_pixels
from rehab_app.vision.contrast import Float32, Image, smoothed
from sessions.records.fields import Float64

_MOST = 400  # blobs looked at, the largest: a bad picture costs a bounded time
_TRIMMED = 0.9  # what is left of a disc's axes once its blurred rim is off
_RIM_SHARE = 0.34  # of a blob's strongest response, below which a pixel is its blurred rim


@dataclass(frozen=True, slots=True)
class Blobs:
    """Blobs of one image.

    Attributes:
        parts: Their pixels.
        mass: Weight of each of those pixels in its blob's centre, shape (P,).
        centre_px: Weighted centres u v, shape (B, 2).
        axes_px: Half axes of the ellipse with the same second moments, longer first, shape (B, 2).
        long_axis: Unit direction of the longer one, shape (B, 2).
        area_px: Number of pixels, shape (B,).
    """

    parts: Parts
    mass: Float64
    centre_px: Float64
    axes_px: Float64
    long_axis: Float64
    area_px: Float64

    def __len__(self) -> int:
        """Number of blobs."""
        return self.parts.count

    def rim_px(self, directions: int) -> Float64:
        """From each centre to the rim of its disc, about the ellipse, shape (B, directions, 2)."""
        angle = np.arange(directions) * (2.0 * np.pi / directions)
        short_axis = np.stack([-self.long_axis[:, 1], self.long_axis[:, 0]], axis=1)
        longer = self.axes_px[:, :1, None] * self.long_axis[:, None] * np.cos(angle)[:, None]
        shorter = self.axes_px[:, 1:, None] * short_axis[:, None] * np.sin(angle)[:, None]
        return (longer + shorter) / _TRIMMED

    def mean_of(self, image: Image) -> Float64:
        """Mean colour of each blob, image (H, W, C) to (B, C)."""
        values = image[self.parts.row, self.parts.column].astype(np.float64)
        sums = [
            np.bincount(self.parts.owner, values[:, channel], len(self)) for channel in range(values.shape[1])
        ]
        return np.stack(sums, axis=1) / np.maximum(self.area_px, 1.0)[:, None]


def find_blobs(tint: Float32, contrast: Float32, threshold: float, area_px: tuple[float, float]) -> Blobs:
    """Connected parts whose smoothed contrast is above a threshold, each less its faint rim.

    What joins two markers is often faint beside both, and a disc in the shade is faint altogether: so the
    threshold is low, and pixels that are faint beside their own part's peak are left out afterwards.

    Args:
        tint: How much of the colour each pixel has; less the level about a blob it weighs its pixels by
            how far ink covers them, shape (H, W).
        contrast: Tint less that of the surround; it decides what belongs to a blob, shape (H, W).
        threshold: Lowest response in a blob.
        area_px: Smallest and largest area kept.
    """
    response = smoothed(contrast)
    parts = connected_parts(response > threshold)
    strength = response[parts.row, parts.column]
    peak = np.zeros(parts.count, dtype=np.float32)
    np.maximum.at(peak, parts.owner, strength)
    strong = strength > _RIM_SHARE * peak[parts.owner]
    parts = joined_pixels(parts.row[strong], parts.column[strong])
    area = np.bincount(parts.owner, minlength=parts.count)
    kept = (area >= area_px[0]) & (area <= area_px[1])
    if kept.sum() > _MOST:
        kept &= area >= np.sort(area[kept])[-_MOST]
    parts = parts.only(kept)
    return measured(parts, _coverage(parts, tint, contrast))


def _coverage(parts: Parts, tint: Float32, contrast: Float32) -> Float64:
    """Tint of each pixel above the mean level about its part, one level for all lest it tilt, shape (P,)."""
    own = tint[parts.row, parts.column].astype(np.float64)
    about = own - contrast[parts.row, parts.column]
    count = np.maximum(np.bincount(parts.owner, minlength=parts.count), 1)
    level = np.bincount(parts.owner, about, parts.count) / count
    return np.maximum(own - level[parts.owner], 0.0)


def measured(parts: Parts, mass: Float64) -> Blobs:
    """Centres and shapes of parts whose pixels have a mass (P,)."""

    def total(values: Float64) -> Float64:
        return np.bincount(parts.owner, values, parts.count).astype(np.float64)

    weight = np.maximum(mass, 1e-6)
    column, row = parts.column.astype(np.float64), parts.row.astype(np.float64)
    whole = total(weight)
    centre = np.stack([total(weight * column), total(weight * row)], axis=1) / whole[:, None]
    du, dv = column - centre[parts.owner, 0], row - centre[parts.owner, 1]
    uu, vv, uv = (total(weight * square) / whole for square in (du * du, dv * dv, du * dv))
    mean, spread = 0.5 * (uu + vv), np.sqrt(0.25 * (uu - vv) ** 2 + uv**2)
    turn = 0.5 * np.arctan2(2.0 * uv, uu - vv)
    axes = 2.0 * np.sqrt(np.stack([mean + spread, np.maximum(mean - spread, 0.0)], axis=1))
    long_axis = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    area = np.bincount(parts.owner, minlength=parts.count).astype(np.float64)
    return Blobs(parts, mass, centre, axes, long_axis, area)
