"""Plain triangle meshes from which a hand is built: a tapered bone, a ball, a smooth loft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from robot_iface.types import Float64, Int64

_AROUND = 24


@dataclass(frozen=True, slots=True)
class Solid:
    """A closed triangle mesh.

    Attributes:
        vertices_m: Vertices, shape (V, 3).
        faces: Rows of vertex numbers, counter-clockwise from outside, shape (F, 3).
    """

    vertices_m: Float64
    faces: Int64


def tapered_bone() -> Solid:
    """A finger segment of unit length and radius along +z, waisted in the middle and slimmer at the end."""
    along = np.linspace(0.0, 1.0, 9)
    return _lathe(along, 1.0 - 0.13 * along - 0.06 * np.sin(np.pi * along))


def ball() -> Solid:
    """A unit sphere."""
    polar = np.linspace(0.0, np.pi, 13)
    return _lathe(-np.cos(polar), np.sin(polar))


def bar() -> Solid:
    """A cylinder of radius 1 and length 1 about z, around the origin."""
    return _lathe(np.array([-0.5, 0.5]), np.ones(2))


def block() -> Solid:
    """A cube of edge 1 around the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
    return Solid(corners, np.array(faces, dtype=np.int64))


def loft(stations_m: Float64) -> Solid:
    """A smooth body through oval cross sections along z, as a forearm runs into a palm.

    Args:
        stations_m: Rows of height z, centre x, centre y, half thickness in x, half width in y, shape (N, 5),
            z increasing; the ends are closed flat.
    """
    smooth: Any = PchipInterpolator(stations_m[:, 0], stations_m[:, 1:], axis=0)
    heights = np.linspace(stations_m[0, 0], stations_m[-1, 0], 36)
    shape = np.asarray(smooth(heights), dtype=np.float64)
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    # a superellipse: flatter on palm and back than an ellipse, still rounded at the edges
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    oval = np.sign(circle) * np.abs(circle) ** 0.8
    rings = np.empty((heights.size, _AROUND, 3))
    rings[..., :2] = shape[:, None, :2] + oval * shape[:, None, 2:]
    rings[..., 2] = heights[:, None]
    return _closed(rings)


def _lathe(heights: Float64, radii: Float64) -> Solid:
    """Turn a profile about z."""
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = np.empty((heights.size, _AROUND, 3))
    rings[..., :2] = radii[:, None, None] * circle
    rings[..., 2] = heights[:, None]
    return _closed(rings)


def _closed(rings: Float64) -> Solid:
    """Skin over rings (N, _AROUND, 3); each end is closed by a point in its middle."""
    ends = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    low = np.arange((len(rings) - 1) * _AROUND)
    after = low - low % _AROUND + (low + 1) % _AROUND
    high, high_after = low + _AROUND, after + _AROUND
    first, second = low[:_AROUND], after[:_AROUND]
    bottom = np.full(_AROUND, rings.shape[0] * _AROUND)
    last = (rings.shape[0] - 1) * _AROUND
    faces = np.concatenate(
        [
            np.stack([low, after, high_after], axis=1),
            np.stack([low, high_after, high], axis=1),
            np.stack([bottom, second, first], axis=1),
            np.stack([bottom + 1, last + first, last + second], axis=1),
        ]
    )
    return Solid(np.concatenate([rings.reshape(-1, 3), ends]), faces.astype(np.int64))
