"""Where to look, and what to keep: the window about the expected hand, and the reach of a hand in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.vision.contrast import Image
from sessions.errors import Refused
from sessions.records.fields import Float64

Window = tuple[int, int, int, int]
"""First row, first column, row after the last, column after the last."""

_MARGIN_M = 0.06
_SMALLEST_PX = 40


def check_sizes(colour_bgr: Image, depth_m: NDArray[np.float32] | None, intrinsics: Intrinsics) -> None:
    """Refuse pictures that are not of the calibrated size.

    Raises:
        Refused: Colour or depth has another size than the intrinsics, or the picture has not three channels.
    """
    wanted = (intrinsics.height_px, intrinsics.width_px)
    bound = f"{wanted[1]} x {wanted[0]} px as calibrated"
    remedy = "set the camera to that size, or calibrate it at its own"
    if colour_bgr.ndim != 3 or colour_bgr.shape[2] != 3 or colour_bgr.dtype != np.uint8:
        raise Refused("picture", f"of shape {colour_bgr.shape}", "of 8-bit blue, green and red", "use colour")
    if colour_bgr.shape[:2] != wanted:
        raise Refused("picture", f"{colour_bgr.shape[1]} x {colour_bgr.shape[0]} px", bound, remedy)
    if depth_m is not None and depth_m.shape != wanted:
        size = " x ".join(str(edge) for edge in depth_m.shape[::-1])
        raise Refused("depth image", f"{size} px", f"{bound} (registered to colour)", remedy)


def window_about(around_m: Float64 | None, intrinsics: Intrinsics) -> Window:
    """Part of the image in which to look: about the expected points (K, 3), or all of it."""
    whole = (0, 0, intrinsics.height_px, intrinsics.width_px)
    if around_m is None:
        return whole
    points = around_m[np.isfinite(around_m).all(axis=1)]
    if not len(points) or not bool((points[:, 2] > 0.1).all()):
        return whole
    pixel = intrinsics.project(points)
    margin = _MARGIN_M * intrinsics.fx_px / float(np.median(points[:, 2]))
    low, high = np.floor(pixel.min(axis=0) - margin), np.ceil(pixel.max(axis=0) + margin)
    left, right = (int(np.clip(edge, 0, whole[3])) for edge in (low[0], high[0]))
    top, bottom = (int(np.clip(edge, 0, whole[2])) for edge in (low[1], high[1]))
    large = right - left > _SMALLEST_PX and bottom - top > _SMALLEST_PX
    return (top, left, bottom, right) if large else whole


def within_reach(
    p_camera_m: Float64, weight: Float64, depth_gate_m: float, reach_m: float
) -> NDArray[np.bool_]:
    """Which points could belong to one hand: those about the weightiest cluster, shape (N,).

    Args:
        p_camera_m: Points, NaN where there is none, shape (N, 3).
        weight: How much each speaks for a hand about it, shape (N,); 0 does not speak.
        depth_gate_m: Greatest distance from the cluster's middle along the optical axis.
        reach_m: Greatest distance from it across that axis.
    """
    voices = np.flatnonzero((weight > 0.0) & np.isfinite(p_camera_m).all(axis=1))
    if not len(voices):
        return np.zeros(len(weight), dtype=np.bool_)
    apart = p_camera_m[voices, None] - p_camera_m[voices]
    near = np.linalg.norm(apart, axis=2) < 0.75 * reach_m
    best = int(np.argmax(near @ weight[voices]))
    middle = np.median(p_camera_m[voices[near[best]]], axis=0)
    offset = p_camera_m - middle
    with np.errstate(invalid="ignore"):
        close = np.abs(offset[:, 2]) < depth_gate_m
        return close & (np.hypot(offset[:, 0], offset[:, 1]) < reach_m)
