"""Depth of a marker from the depth image: a robust middle over its disc, and how sure that is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.blobs import Blobs
from sessions.records.fields import Float64, Int64

_OUTLIER_M = 0.015
_FLOOR_STD_M = 0.0004  # rounding to millimetres and what neighbours share does not average out
_PIXEL_STD_M = 0.0012  # of one pixel at 0.7 m, growing with the square of the distance
_RIM_STD_M = 0.006  # of a depth that the skin around a disc lends it
_BEARING_M = 0.02  # a marker lies on skin: about it there is some within so much of its depth
_FEWEST = 3
_STRETCH = (1.6, 2.0, 2.5)  # of a disc's box; its paper ring ends at 1.33
_DIRECTIONS = 20


def disc_depth(blobs: Blobs, depth_m: NDArray[np.float32], min_pixels: int = 4) -> tuple[Float64, Float64]:
    """Depth along the optical axis at each blob's centre.

    A plane seen at a slant has its middle depth at its middle, so the median over the disc is unbiased;
    pixels more than 15 mm from it (a finger behind, an edge) are left out of the mean that follows.

    Args:
        blobs: Blobs of the colour image.
        depth_m: Depth registered to it, shape (H, W); 0 or NaN where there is none.
        min_pixels: Fewest pixels with depth.

    Returns:
        Depth and its standard deviation, both (B,), m; NaN where too few pixels have any.
    """
    values = depth_m[blobs.parts.row, blobs.parts.column].astype(np.float64)
    valid = values > 0.0  # drops NaN as well
    owner, values = blobs.parts.owner[valid], values[valid]
    middle = _medians(owner, values, len(blobs))
    near = np.abs(values - middle[owner]) < _OUTLIER_M
    owner, values = owner[near], values[near]
    count = np.bincount(owner, minlength=len(blobs)).astype(np.float64)
    total = np.bincount(owner, values, len(blobs))
    with np.errstate(invalid="ignore", divide="ignore"):
        depth = np.where(count >= min_pixels, total / count, np.nan)
        variance = np.bincount(owner, (values - depth[owner]) ** 2, len(blobs)) / count
        noise = _PIXEL_STD_M * (depth / 0.7) ** 2
        # a third of the pixels count: neighbours share their noise; a slanted disc spreads but stays unbiased
        std = np.sqrt(_FLOOR_STD_M**2 + (noise**2 + 0.25 * variance) * 3.0 / count)
    return depth, std


def supported(
    blobs: Blobs, depth_m: NDArray[np.float32], depth: Float64, std: Float64
) -> tuple[Float64, Float64, NDArray[np.bool_]]:
    """Depths of discs, put right where nothing about a disc bears it.

    A marker lies on a surface: where its disc has no depth, or one that nothing around it shares, it takes
    that of the likeliest surface about its rim (nearest to its own depth, else to the camera), less surely.

    Args:
        blobs: Blobs of the colour image.
        depth_m: Depth registered to it, shape (H, W); 0 or NaN where there is none.
        depth: Depth of each disc, NaN where unknown, shape (B,), m.
        std: Its standard deviation, shape (B,), m.

    Returns:
        Depth, its standard deviation, and whether the disc's own depth was borne out (or nothing is known
        against it), all (B,).
    """
    rim = _rims(blobs, depth_m)
    with np.errstate(invalid="ignore"):
        borne = (np.abs(rim - depth[:, None]) < _BEARING_M).sum(axis=1) >= _FEWEST
    known = np.isfinite(rim).sum(axis=1) >= 2 * _FEWEST
    known_rim = np.where(np.isfinite(rim), rim, np.inf)
    apart = np.where(np.isfinite(depth)[:, None], np.abs(known_rim - depth[:, None]), known_rim)
    likely = np.take_along_axis(known_rim, np.argmin(apart, axis=1)[:, None], axis=1)
    with np.errstate(invalid="ignore"):
        close = np.abs(known_rim - likely) < _BEARING_M
    count = close.sum(axis=1)
    middle = np.where(close, rim, 0.0).sum(axis=1) / np.maximum(count, 1)
    lent = known & ~borne & (count >= _FEWEST)
    clear = borne | ~known | ~np.isfinite(depth)
    return np.where(lent, middle, depth), np.where(lent, _RIM_STD_M, std), clear


def _medians(owner: Int64, values: Float64, count: int) -> Float64:
    """Median of the values of each owner, shape (count,); NaN of those without any."""
    order = np.lexsort((values, owner))
    number = np.bincount(owner, minlength=count)
    first = np.cumsum(number) - number
    medians = np.full(count, np.nan)
    some = number > 0
    ranked = values[order]
    low = first[some] + (number[some] - 1) // 2
    high = first[some] + number[some] // 2
    medians[some] = 0.5 * (ranked[low] + ranked[high])
    return medians


def _rims(blobs: Blobs, depth_m: NDArray[np.float32]) -> Float64:
    """Depths about each blob, NaN where there is none, shape (B, R)."""
    height, width = depth_m.shape
    rim = blobs.rim_px(_DIRECTIONS)[:, None] * np.array(_STRETCH)[:, None, None]
    places = blobs.centre_px[:, None, None] + rim
    column = np.clip(np.rint(places[..., 0]), 0, width - 1).astype(np.int64)
    row = np.clip(np.rint(places[..., 1]), 0, height - 1).astype(np.int64)
    around = depth_m[row, column].astype(np.float64).reshape(len(blobs), len(_STRETCH) * _DIRECTIONS)
    around[~(around > 0.0)] = np.nan
    return around
