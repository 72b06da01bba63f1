"""Which points of a hand another part of it hides: lines of sight against capsules, in closed form."""

from __future__ import annotations

import numpy as np

from rehab_app.cameras.paper_markers import DISC_RADIUS_M, PlacedMarkers
from rehab_app.cameras.skin import Capsules
from sessions.records.fields import Float64

_TUCK_M = 0.0012  # skin may stand this much over a disc's plane without hiding it, as when it is drawn
_SPOTS = np.array([[0.0, 0.0], [0.62, 0.0], [0.0, 0.62], [-0.62, 0.0], [0.0, -0.62]])


def open_spots(markers: PlacedMarkers, skin: Capsules) -> tuple[Float64, Float64]:
    """Five spots of every disc and whether a camera at the origin sees them past the skin.

    Args:
        markers: Discs in the camera frame.
        skin: The hand in the camera frame.

    Returns:
        The spots (M, 5, 3) in m, the centre first, and 1 where open, 0 where hidden (M, 5). Whether a disc
        faces away is not asked here.
    """
    across = _across(markers.normal)
    spread: Float64 = DISC_RADIUS_M * np.einsum("si,mik->msk", _SPOTS, across)
    spots: Float64 = markers.p_camera_m[:, None] + spread
    free = (gaps(spots.reshape(-1, 3), skin) >= skin.radius_m - _TUCK_M).all(axis=1)
    return spots, np.asarray(free, np.float64).reshape(spots.shape[:2])


def gaps(points_m: Float64, skin: Capsules) -> Float64:
    """Smallest distance between each line of sight (origin to point) and each capsule's axis, (N, C), m."""
    ray, axis = points_m[:, None], (skin.end_m - skin.begin_m)[None]
    begin = skin.begin_m[None]
    a, e = _dot(ray, ray), _dot(axis, axis)
    b, c, f = _dot(ray, axis), -_dot(ray, begin), -_dot(axis, begin)
    # nearest points of two segments: clamp one, then the other, then the first again (Ericson 2005, 5.1.9)
    wide = np.maximum(a * e - b * b, 1e-18)
    along_ray = np.clip((b * f - c * e) / wide, 0.0, 1.0)
    along_axis = np.clip((b * along_ray + f) / e, 0.0, 1.0)
    along_ray = np.clip((b * along_axis - c) / a, 0.0, 1.0)
    apart: Float64 = along_ray[..., None] * ray - begin - along_axis[..., None] * axis
    return np.sqrt((apart**2).sum(axis=-1))


def _dot(a: Float64, b: Float64) -> Float64:
    product: Float64 = np.einsum("...i,...i->...", a, b)
    return product


def _across(normal: Float64) -> Float64:
    """Two unit vectors across each normal (M, 3), shape (M, 2, 3)."""
    least = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second: Float64 = np.asarray(np.cross(normal, first), np.float64)
    return np.stack([np.asarray(first, np.float64), second], axis=1)
