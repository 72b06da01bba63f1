"""Depth of a marker from the depth image: a robust middle over its disc, and how sure that is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.blobs import Blobs
from sessions.records.fields import Float64

_OUTLIER_M = 0.015
_FLOOR_STD_M = 0.0004  # rounding to millimetres and what neighbours share does not average out
_PIXEL_STD_M = 0.0012  # of one pixel at 0.7 m, growing with the square of the distance


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
    depth = np.full(len(blobs.number), np.nan)
    std = np.full(len(blobs.number), np.nan)
    for index, (number, box) in enumerate(zip(blobs.number, blobs.box_px, strict=True)):
        u, v, width, height = (int(edge) for edge in box)
        part = np.s_[v : v + height, u : u + width]
        values = depth_m[part][blobs.labels[part] == number].astype(np.float64)
        values = values[values > 0.0]  # drops NaN as well
        if len(values) < min_pixels:
            continue
        near = values[np.abs(values - np.median(values)) < _OUTLIER_M]
        if len(near) < min_pixels:
            continue
        depth[index] = near.mean()
        noise = _PIXEL_STD_M * (depth[index] / 0.7) ** 2
        # a third of the pixels count: neighbours share their noise; a slanted disc spreads but stays unbiased
        std[index] = np.sqrt(_FLOOR_STD_M**2 + (noise**2 + 0.25 * near.var()) * 3.0 / len(near))
    return depth, std
