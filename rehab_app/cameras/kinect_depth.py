"""Raw depth of a Kinect v1: to metres, and registered to its colour image by the usual geometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.frame import Depth
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import UInt16

NO_DEPTH = 2047
"""Raw value where the sensor saw no depth."""

DEPTH_CAMERA = Intrinsics(580.0, 580.0, 319.5, 239.5, 640, 480)
"""The infrared camera, which sees the depth."""

BASELINE_M = 0.025
"""The colour camera stands this far to the right of the infrared one, as they look."""

_NEAR_RAW, _FAR_RAW = 300, 1083  # about 0.4 m and 8 m: beyond them the formula means nothing


def metres(raw: UInt16) -> Depth:
    """Depth of 11-bit raw values, same shape, m; 0 where unknown.

    Source: the tangent fit of S. Magnenat, 0.1236 tan(raw / 2842.5 + 1.1863) (openkinect.org, Imaging
    Information).
    """
    return _TABLE[np.minimum(raw, NO_DEPTH)]


def registered(depth_m: Depth, colour: Intrinsics) -> Depth:
    """Depth of the infrared camera as the colour camera would see it, shape (H, W) of the colour image, m.

    Where several points fall into one pixel the nearest one hides the others.
    """
    row, column = np.nonzero(depth_m)
    z = depth_m[row, column]
    x = (column - DEPTH_CAMERA.cx_px) / DEPTH_CAMERA.fx_px * z - BASELINE_M
    y = (row - DEPTH_CAMERA.cy_px) / DEPTH_CAMERA.fy_px * z
    u = np.rint(colour.fx_px * x / z + colour.cx_px).astype(np.int64)
    v = np.rint(colour.fy_px * y / z + colour.cy_px).astype(np.int64)
    inside = (u >= 0) & (u < colour.width_px) & (v >= 0) & (v < colour.height_px)
    u, v, z = u[inside], v[inside], z[inside]
    out = np.zeros((colour.height_px, colour.width_px), np.float32)
    far_first = np.argsort(-z, kind="stable")  # what is assigned last stays
    out[v[far_first], u[far_first]] = z[far_first]
    return out


def _table() -> NDArray[np.float32]:
    raw = np.arange(NO_DEPTH + 1)
    table = np.zeros(NO_DEPTH + 1, np.float32)
    valid = (raw >= _NEAR_RAW) & (raw <= _FAR_RAW)
    table[valid] = 0.1236 * np.tan(raw[valid] / 2842.5 + 1.1863)
    return table


_TABLE = _table()
