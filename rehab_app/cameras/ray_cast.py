"""Depth and shading of capsules as a pinhole camera sees them: closed form, one image box per capsule."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.skin import Capsules
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

Float32 = NDArray[np.float32]
Box = tuple[int, int, int, int]
"""Part of an image: first row, row after the last, first column, column after the last."""


@dataclass(frozen=True, slots=True)
class SurfaceImage:
    """What a ray through every pixel meets first.

    Attributes:
        box: The part of the image that holds everything; the arrays have its size.
        depth_m: Depth along the optical axis, infinite where nothing is met, shape (h, w).
        shade: Cosine between the surface's normal and the light, shape (h, w).
    """

    box: Box
    depth_m: Float32
    shade: Float32


def cast(capsules: Capsules, light: Float64, intrinsics: Intrinsics) -> SurfaceImage:
    """Cast a ray through every pixel that a capsule may cover.

    Args:
        capsules: Surfaces in the camera frame.
        light: Unit direction towards the light in the camera frame, shape (3,).
        intrinsics: The camera.
    """
    boxes = [_box(capsules, index, intrinsics) for index in range(len(capsules.radius_m))]
    filled = [box for box in boxes if box[1] > box[0] and box[3] > box[2]]
    if not filled:
        return SurfaceImage((0, 0, 0, 0), np.empty((0, 0), np.float32), np.empty((0, 0), np.float32))
    edges = np.array(filled)
    whole = (int(edges[:, 0].min()), int(edges[:, 1].max()), int(edges[:, 2].min()), int(edges[:, 3].max()))
    size = (whole[1] - whole[0], whole[3] - whole[2])
    depth = np.full(size, np.inf, dtype=np.float32)
    shade = np.zeros(size, dtype=np.float32)
    for index, box in enumerate(boxes):
        if box[1] > box[0] and box[3] > box[2]:
            part = np.s_[box[0] - whole[0] : box[1] - whole[0], box[2] - whole[2] : box[3] - whole[2]]
            _draw(capsules, index, light, ray_grid(box, intrinsics), depth[part], shade[part])
    return SurfaceImage(whole, depth, shade)


def ray_grid(box: Box, intrinsics: Intrinsics) -> tuple[Float32, Float32]:
    """x/z of every column (1, w) and y/z of every row (h, 1) of a box."""
    columns = (np.arange(box[2], box[3], dtype=np.float32) - intrinsics.cx_px) / intrinsics.fx_px
    rows = (np.arange(box[0], box[1], dtype=np.float32) - intrinsics.cy_px) / intrinsics.fy_px
    return columns[None, :].astype(np.float32), rows[:, None].astype(np.float32)


def _box(capsules: Capsules, index: int, intrinsics: Intrinsics) -> Box:
    """Image box of a capsule: that of its end spheres, with a margin; empty behind the camera."""
    ends = np.stack([capsules.begin_m[index], capsules.end_m[index]])
    radius = capsules.radius_m[index]
    if ends[:, 2].min() <= 2 * radius:
        return (0, 0, 0, 0)
    pixel = intrinsics.project(ends)
    reach = 1.0 + 1.1 * radius * max(intrinsics.fx_px, intrinsics.fy_px) / (ends[:, 2] - radius)
    low = np.floor((pixel - reach[:, None]).min(axis=0)).astype(int)
    high = np.ceil((pixel + reach[:, None]).max(axis=0)).astype(int) + 1
    size = (intrinsics.width_px, intrinsics.height_px)
    u0, u1 = (int(np.clip(edge, 0, size[0])) for edge in (low[0], high[0]))
    v0, v1 = (int(np.clip(edge, 0, size[1])) for edge in (low[1], high[1]))
    return (v0, v1, u0, u1)


def _draw(
    capsules: Capsules,
    index: int,
    light: Float64,
    rays: tuple[Float32, Float32],
    depth: Float32,
    shade: Float32,
) -> None:
    """Draw one capsule into the views ``depth`` and ``shade`` of its box, nearest surface first.

    The ray z (x, y, 1) meets the cylinder about begin + s axis, 0 < s < 1, where a quadratic in z vanishes;
    beyond the ends it meets the end spheres.
    """
    x, y = rays
    begin, radius = capsules.begin_m[index], float(capsules.radius_m[index])
    axis = capsules.end_m[index] - begin
    length2 = float(axis @ axis)
    ray2 = (x * x + y * y + np.float32(1.0)).astype(np.float32, copy=False)
    along = _dot(x, y, axis)
    to_begin = _dot(x, y, begin)
    offset = float(axis @ begin)
    z = _nearer_root(
        (np.float32(length2) * ray2 - along * along).astype(np.float32, copy=False),
        (np.float32(length2) * to_begin - np.float32(offset) * along).astype(np.float32, copy=False),
        length2 * (float(begin @ begin) - radius**2) - offset**2,
    )
    share = np.clip((z * along - offset) / length2, 0.0, 1.0)
    for end, side in ((begin, 0.0), (capsules.end_m[index], 1.0)):
        cap = _nearer_root(ray2, _dot(x, y, end), float(end @ end) - radius**2)
        z = np.where(share == side, cap, z)
    hit = np.isfinite(z) & (z < depth)
    cosine = (z * _dot(x, y, light) - float(light @ begin) - share * float(light @ axis)) / radius
    depth[hit] = z[hit]
    shade[hit] = cosine[hit]


def _dot(x: Float32, y: Float32, vector: Float64) -> Float32:
    """Rays (x, y, 1) times a vector, shape (h, w)."""
    rays: Float32 = (x * np.float32(vector[0]) + y * np.float32(vector[1]) + np.float32(vector[2])).astype(
        np.float32, copy=False
    )
    return rays


def _nearer_root(a: Float32, b: Float32, c: float) -> Float32:
    """Smaller root of a z^2 - 2 b z + c = 0; NaN where the ray misses, infinite along the axis."""
    with np.errstate(invalid="ignore", divide="ignore"):
        root: Float32 = (b - np.sqrt(b * b - a * np.float32(c))) / a
    return root
