"""Paper markers: a blue disc in a white ring, drawn with the part of each pixel that they cover."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.frame import Colour
from rehab_app.cameras.ray_cast import Box, Float32, SurfaceImage, ray_grid
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

DISC_RADIUS_M = 0.006
RING_RADIUS_M = 0.008
_BLUE_BGR = np.array([196.0, 92.0, 34.0], dtype=np.float32)
_WHITE_BGR = np.array([238.0, 238.0, 238.0], dtype=np.float32)
_TUCK_M = (
    0.0012  # skin may stand this much over a disc's plane without hiding it: paper bends, capsules do not
)
_EDGE_ON = 0.08  # cosine below which a disc is no more than a line


@dataclass(frozen=True, slots=True)
class PlacedMarkers:
    """Discs in the camera frame.

    Attributes:
        p_camera_m: Centres, shape (M, 3).
        normal: Unit normals out of the skin, shape (M, 3).
    """

    p_camera_m: Float64
    normal: Float64

    def facing(self) -> Float64:
        """Cosine between each normal and the way to the camera, shape (M,); negative faces away."""
        away = self.p_camera_m / np.linalg.norm(self.p_camera_m, axis=1, keepdims=True)
        return -np.einsum("mi,mi->m", self.normal, away)


@dataclass(frozen=True, slots=True)
class Papers:
    """What the markers are made of, and what goes wrong with them.

    Attributes:
        disc_radius_m: Radius of each blue disc, shape (M,).
        ring_radius_m: Radius of the white paper, that of the disc where there is no ring, shape (M,).
        depth_error_m: By how much the depth at each is wrong, NaN where it has none, shape (M,).
        shown: Whether each is there at all, shape (M,).
    """

    disc_radius_m: Float64
    ring_radius_m: Float64
    depth_error_m: Float64
    shown: NDArray[np.bool_]


def sound_papers(count: int) -> Papers:
    """Whole markers of the usual size."""
    disc, ring = np.full(count, DISC_RADIUS_M), np.full(count, RING_RADIUS_M)
    return Papers(disc, ring, np.zeros(count), np.ones(count, dtype=np.bool_))


def draw(
    markers: PlacedMarkers,
    papers: Papers,
    surface: SurfaceImage,
    colour: Colour,
    light: Float64,
    intrinsics: Intrinsics,
) -> Float64:
    """Draw the markers over a surface, in place, far ones first.

    Args:
        markers: Where they are.
        papers: What they are made of.
        surface: Skin; its depth is overwritten where a marker covers it.
        colour: Image of the surface's box, shape (h, w, 3); drawn into.
        light: Unit direction towards the light in the camera frame.
        intrinsics: The camera.

    Returns:
        Share of each blue disc that is seen, shape (M,); 0 where it faces away.
    """
    seen = np.zeros(len(markers.p_camera_m))
    facing = markers.facing()
    for index in np.argsort(-markers.p_camera_m[:, 2]):
        if facing[index] > _EDGE_ON and papers.shown[index]:
            seen[index] = _draw_one(markers, papers, int(index), surface, colour, light, intrinsics)
    return seen


def _draw_one(
    markers: PlacedMarkers,
    papers: Papers,
    index: int,
    surface: SurfaceImage,
    colour: Colour,
    light: Float64,
    intrinsics: Intrinsics,
) -> float:
    """Draw one marker; the share of its disc that the skin does not hide."""
    centre, normal = markers.p_camera_m[index], markers.normal[index]
    box = _clipped(centre, float(papers.ring_radius_m[index]), surface.box, intrinsics)
    if box[1] <= box[0] or box[3] <= box[2]:
        return 0.0
    x, y = ray_grid(box, intrinsics)
    slant = x * np.float32(normal[0]) + y * np.float32(normal[1]) + np.float32(normal[2])
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.float32(normal @ centre) / slant
    radius = np.sqrt((z * x - centre[0]) ** 2 + (z * y - centre[1]) ** 2 + (z - centre[2]) ** 2)
    part = np.s_[
        box[0] - surface.box[0] : box[1] - surface.box[0], box[2] - surface.box[2] : box[3] - surface.box[2]
    ]
    open_view = (z > 0) & (z <= surface.depth_m[part] + _TUCK_M)
    disc_m, ring_m = float(papers.disc_radius_m[index]), float(papers.ring_radius_m[index])
    disc, paper = _coverage(radius, disc_m), _coverage(radius, ring_m)
    shade = 0.62 + 0.38 * max(float(normal @ light), 0.0)
    ink = disc[..., None] * _BLUE_BGR + (1.0 - disc[..., None]) * _WHITE_BGR
    share = (paper * open_view)[..., None]
    colour[part] = ((1.0 - share) * colour[part] + share * shade * ink + 0.5).astype(np.uint8)
    covered = open_view & (paper > 0.5)
    error = papers.depth_error_m[index]
    surface.depth_m[part][covered] = z[covered] + np.float32(error) if np.isfinite(error) else 0.0
    whole = _whole_disc_px(centre, disc_m, float(markers.facing()[index]), intrinsics)
    return float((disc * open_view).sum() / max(whole, 1e-9))


def _whole_disc_px(centre: Float64, disc_m: float, facing: float, intrinsics: Intrinsics) -> float:
    """Area of an unhidden disc in the image, px^2."""
    return float(np.pi * disc_m**2 * facing * intrinsics.fx_px * intrinsics.fy_px / centre[2] ** 2)


def _coverage(radius: Float32, limit_m: float) -> Float32:
    """Share of each pixel within ``limit_m`` of a centre, from the radius and its slope over the image."""
    by_row, by_column = np.gradient(radius)
    slope = np.sqrt(by_row**2 + by_column**2) + np.float32(1e-9)
    share: Float32 = np.clip((limit_m - radius) / slope + 0.5, 0.0, 1.0)
    return share


def _clipped(centre: Float64, ring_m: float, whole: Box, intrinsics: Intrinsics) -> Box:
    """Image box of a marker within the box of the surface."""
    u, v = intrinsics.project(centre)
    reach = 2.0 + 1.2 * ring_m * intrinsics.fx_px / centre[2]
    return (
        max(int(v - reach), whole[0]),
        min(int(v + reach) + 2, whole[1]),
        max(int(u - reach), whole[2]),
        min(int(u + reach) + 2, whole[3]),
    )
