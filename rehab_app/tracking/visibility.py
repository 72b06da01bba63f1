"""How likely each marker is to be detected at all: it may face away, or have been hidden a moment ago."""

from __future__ import annotations

import numpy as np

from sessions.records.fields import Float64, Int64

_DETECTED = 0.95  # chance of a marker in plain view
_MOST, _LEAST = 0.97, 0.01
_HIDES_HZ = 1.0
_SHOWS_HZ = 4.0
_EDGE_ON = 0.05  # cosine between normal and line of sight at which half of the markers are still found
_SOFT = 0.07


def facing_chance(normal_camera: Float64, p_camera_m: Float64, origin_m: Float64) -> Float64:
    """Share of markers like these that a camera at ``origin_m`` (3,) sees the front of, shape (M,).

    Args:
        normal_camera: Unit normals, shape (M, 3).
        p_camera_m: Places, shape (M, 3).
        origin_m: Optical centre, shape (3,).
    """
    line = p_camera_m - origin_m
    cosine = -np.einsum("mi,mi->m", normal_camera, line) / np.linalg.norm(line, axis=1)
    return 1.0 / (1.0 + np.exp(-(cosine - _EDGE_ON) / _SOFT))


def shown_chance(shown: Float64, span_s: float) -> Float64:
    """Probability that each marker is in plain view now, from that a while ago, shape (M,)."""
    lasting = np.exp(-(_HIDES_HZ + _SHOWS_HZ) * span_s)
    usual = _SHOWS_HZ / (_HIDES_HZ + _SHOWS_HZ)
    return usual + (shown - usual) * lasting


def seen_chance(shown: Float64, facing: Float64) -> Float64:
    """Probability of a detection of each marker, shape (M,)."""
    return np.clip(_DETECTED * shown * facing, _LEAST, _MOST)


def shown_after(shown: Float64, detected: Int64) -> Float64:
    """Probability that each marker is in plain view after a capture that showed the markers ``detected``."""
    missed = shown * (1.0 - _DETECTED)
    result = missed / (missed + 1.0 - shown + 1e-9)
    result[detected] = 1.0
    return result
