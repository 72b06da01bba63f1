"""Two markers in one blob: taken apart where the tint dips between them, where depth steps, or by length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.blobs import Blobs, measured
from rehab_app.vision.components import Parts, joined_pixels
from sessions.records.fields import Float64, Int64

_LEVELS = (0.48, 0.64, 0.8)  # of a blob's peak, at which it may fall apart
_SMALLEST_PX = 4
_SMALLEST_SHARE = 0.14
_SHORTEST = 0.45  # of the expected half axis: what is shorter is a crumb, not a marker
_LONG = 1.25  # of the expected half axis: no single disc is longer
_VERY_LONG = 1.6
_SLENDER = 0.75  # a longer blob that is rounder than this is one large disc
_STEP_M = 0.006
_MOST = 16  # long blobs looked at in one image


def split_merged(blobs: Blobs, expected_px: Float64, depth_m: NDArray[np.float32] | None) -> Blobs:
    """Blobs with the merged ones taken apart.

    Args:
        blobs: Blobs of one image, weighed by contrast without smoothing, in which a narrow gap still shows.
        expected_px: Half axis of a whole disc at each blob's depth, NaN where unknown, shape (B,).
        depth_m: Depth image, shape (H, W), or None.
    """
    if not len(blobs):
        return blobs
    seeds = _seeds(blobs, expected_px)
    parted = np.flatnonzero(np.bincount(blobs.parts.owner, seeds >= 0, len(blobs)) > 0)
    groups = [(pixels, _nearest_seed(blobs, pixels, seeds[pixels])) for pixels in _pixels(blobs, parted)]
    ratio = blobs.axes_px[:, 0] / expected_px
    long = np.setdiff1d(np.flatnonzero(ratio > _LONG), parted)[:_MOST]
    for blob, pixels in zip(long, _pixels(blobs, long), strict=True):
        groups.append((pixels, _by_shape(blobs, int(blob), pixels, float(ratio[blob]), depth_m)))
    owner, count = blobs.parts.owner.copy(), len(blobs)
    for pixels, group in groups:
        owner[pixels[group > 0]] = count + group[group > 0] - 1
        count += int(group.max())
    if count == len(blobs):
        return blobs
    return measured(Parts(blobs.parts.row, blobs.parts.column, owner, count), blobs.mass)


def _pixels(blobs: Blobs, chosen: Int64) -> list[Int64]:
    """Pixels of some blobs."""
    return [np.flatnonzero(blobs.parts.owner == blob) for blob in chosen]


def _seeds(blobs: Blobs, expected_px: Float64) -> Int64:
    """Peak of each pixel (P,) in the blobs that a rising level parts; -1 of every other pixel."""
    owner, strength = blobs.parts.owner, blobs.mass
    peak = _high_values(strength, owner, len(blobs))
    seeds = np.full(len(owner), -1, dtype=np.int64)
    whole = blobs.area_px >= 2 * _SMALLEST_PX
    for level in _LEVELS:
        high = np.flatnonzero(whole[owner] & (strength > level * peak[owner]))
        tops = joined_pixels(blobs.parts.row[high], blobs.parts.column[high])
        if tops.count <= whole.sum():  # each blob is still in one piece
            continue
        parent = np.zeros(tops.count, dtype=np.int64)
        parent[tops.owner] = owner[high]
        shape = measured(tops, strength[high])
        good = shape.area_px >= np.maximum(_SMALLEST_PX, _SMALLEST_SHARE * blobs.area_px[parent])
        good &= ~(shape.axes_px[:, 0] < _SHORTEST * expected_px[parent])
        several = np.bincount(parent[good], minlength=len(blobs)) > 1
        taken = (good & several[parent])[tops.owner]
        seeds[high[taken]] = tops.owner[taken]
        whole &= ~several
    return seeds


def _high_values(strength: Float64, owner: Int64, count: int) -> Float64:
    """A strong value of each owner that no single pixel decides: mean plus one deviation, shape (count,)."""
    number = np.maximum(np.bincount(owner, minlength=count), 1)
    mean = np.bincount(owner, strength, count) / number
    square = np.bincount(owner, strength * strength, count) / number
    return mean + np.sqrt(np.maximum(square - mean * mean, 0.0))


def _nearest_seed(blobs: Blobs, pixels: Int64, seeds: Int64) -> Int64:
    """Group of each pixel of one blob, counted from 0: that of the nearest pixel with a seed."""
    row, column = blobs.parts.row[pixels], blobs.parts.column[pixels]
    known = np.flatnonzero(seeds >= 0)
    away = (row[:, None] - row[known]) ** 2 + (column[:, None] - column[known]) ** 2
    return np.unique(seeds[known[np.argmin(away, axis=1)]], return_inverse=True)[1]


def _by_shape(
    blobs: Blobs, blob: int, pixels: Int64, ratio: float, depth_m: NDArray[np.float32] | None
) -> Int64:
    """Group of each pixel of a blob that is too long: by a step in depth, or halves of a slender one."""
    row, column = blobs.parts.row[pixels], blobs.parts.column[pixels]
    group = np.zeros(len(pixels), dtype=np.int64)
    if depth_m is not None:
        group = _by_depth(depth_m[row, column].astype(np.float64))
    slender = blobs.axes_px[blob, 1] < _SLENDER * blobs.axes_px[blob, 0]
    if group.max() == 0 and slender and ratio > _VERY_LONG:
        offset = np.stack([column, row], axis=1) - blobs.centre_px[blob]
        group = (offset @ blobs.long_axis[blob] > 0.0).astype(np.int64)
    return group


def _by_depth(depth_m: Float64) -> Int64:
    """Two groups on either side of the widest step in depth, where it is one."""
    known = np.flatnonzero(depth_m > 0.0)
    group = np.zeros(len(depth_m), dtype=np.int64)
    least = max(_SMALLEST_PX, int(0.2 * len(depth_m)))
    if len(known) < 2 * least:
        return group
    ranked = np.sort(depth_m[known])
    steps = np.diff(ranked)[least - 1 : len(ranked) - least]
    widest = int(np.argmax(steps)) if len(steps) else 0
    if not len(steps) or steps[widest] < _STEP_M:
        return group
    border = ranked[least - 1 + widest] + 0.5 * steps[widest]
    return (depth_m > border).astype(np.int64)
