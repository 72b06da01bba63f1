"""A marker's colour learnt from a click on one, or found by looking for discs of any colour."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.vision.colour import COLOURS, ColourModel, colour_model, named_colour
from rehab_app.vision.contrast import Image
from rehab_app.vision.detector import ContrastDetector, DetectorSettings
from sessions.errors import Refused
from sessions.records.fields import Float64

_LARGEST_PX = 40
_SEED_PX = 1.5
_EDGE = 0.10  # least change of chroma and brightness at the edge of a disc
_HUES_DEG = tuple(range(0, 360, 30))
_FEWEST = 3
_RINGED = 1.2  # by how much paper about a disc is whiter than what lies farther out


def learn_colour(
    colour_bgr: Image, pixel_px: tuple[float, float], radius_px: float | None = None, *, name: str = "own"
) -> ColourModel:
    """The colour of the marker that a person clicked.

    Args:
        colour_bgr: Image, shape (H, W, 3).
        pixel_px: Where the click was, u v, within the coloured disc.
        radius_px: Radius of the disc; measured about the click if None.
        name: What to call the colour.

    Raises:
        Refused: The click is outside the image, or there is no disc about it that stands out.
    """
    height, width = colour_bgr.shape[:2]
    u, v = pixel_px
    if not (2 <= u < width - 2 and 2 <= v < height - 2):
        raise Refused("click", f"at {u:.0f}, {v:.0f}", f"within {width} x {height} px", "click on a marker")
    away = _distances(colour_bgr, u, v)
    radius = _radius(colour_bgr, away) if radius_px is None else radius_px
    if not 1.0 <= radius <= _LARGEST_PX:
        raise Refused("disc", f"{radius:.0f} px in radius", f"1 to {_LARGEST_PX} px", "click on one marker")
    return _learnt(colour_bgr, np.array([[u, v]]), np.array([radius]), name)


def learn_patch(patch_bgr: Image, *, name: str = "own") -> ColourModel:
    """The colour of a marker cut out of an image with some of its surround, shape (h, w, 3).

    Raises:
        Refused: The patch is too small, or no disc in its middle stands out.
    """
    height, width = patch_bgr.shape[:2]
    if min(height, width) < 8:
        raise Refused(
            "patch", f"{width} x {height} px", "8 x 8 px or more", "cut the marker with its surround"
        )
    return learn_colour(patch_bgr, (0.5 * (width - 1), 0.5 * (height - 1)), name=name)


def find_colour(
    colour_bgr: Image, depth_m: NDArray[np.float32] | None, intrinsics: Intrinsics,
    settings: DetectorSettings | None = None,
) -> ColourModel:  # fmt: skip
    """The colour of the markers in a picture of the open hand, found without a click.

    Discs in white rings are looked for in twelve hues and in black; the colour that gives the most convincing
    set is learnt from the picture itself.

    Args:
        colour_bgr: Image, shape (H, W, 3).
        depth_m: Depth, shape (H, W), or None.
        intrinsics: The camera.
        settings: What a marker looks like besides its colour.

    Raises:
        Refused: No colour gives three markers or more.
    """
    shape = settings or DetectorSettings()
    best: tuple[float, Detections | None] = (0.0, None)
    for guess in _guesses():
        seen = ContrastDetector(guess, shape).detect(0, colour_bgr, depth_m, intrinsics)
        worth = float((seen.similarity**2).sum())
        if len(seen) >= _FEWEST and worth > best[0]:
            best = (worth, seen)
    if best[1] is None:
        raise Refused(
            "marker colour", "not to be found", f"shown by {_FEWEST} markers or more",
            "show the back of the open hand, or click on a marker",
        )  # fmt: skip
    found = best[1].rows(np.argsort(-best[1].similarity)[:12])
    depth = found.p_camera_m[:, 2]
    usual = np.nanmedian(depth) if np.isfinite(depth).any() else 0.7
    radius = shape.disc_radius_m * intrinsics.fx_px / np.where(np.isfinite(depth), depth, usual)
    model = _learnt(colour_bgr, found.pixel_px, radius, "found")
    return replace(model, name=_nearest_name(model), ring=True)  # they were found by it


def _guesses() -> list[ColourModel]:
    """Models of inks of all hues, and of black."""
    guesses = [named_colour("black")]
    black = named_colour("black")
    surround = np.array([[238.0, 238.0, 238.0], [118.0, 152.0, 205.0], [60.0, 85.0, 135.0]])
    light = np.array([0.5, 0.75, 1.0])
    for hue in _HUES_DEG:
        pixel = np.array([[[hue // 2, 190, 190]]], dtype=np.uint8)
        ink = np.asarray(cv2.cvtColor(pixel, cv2.COLOR_HSV2BGR), np.float64)[0]
        rest = (surround * light[:, None, None]).reshape(-1, 3)
        guesses.append(colour_model(f"hue {hue}", ink * light[:, None], rest, ring=black.ring))
    return guesses


def _nearest_name(model: ColourModel) -> str:
    """The named colour that a learnt one is most like."""
    if model.darkness > 0:
        return "black"
    own = np.array([model.ink_bgr])
    likeness = {name: float(named_colour(name).is_like(own)[0]) for name in COLOURS if name != "black"}
    return max(likeness, key=lambda name: likeness[name])


def _learnt(colour_bgr: Image, centre_px: Float64, radius_px: Float64, name: str) -> ColourModel:
    """Model from discs at centres (N, 2) of radii (N,)."""
    inside, around, whiter = [], [], []
    weakest = colour_bgr.min(axis=2)
    for (u, v), radius in zip(centre_px, radius_px, strict=True):
        away = _distances(colour_bgr, float(u), float(v))
        inside.append(colour_bgr[away <= max(_SEED_PX, 0.6 * radius)])
        around.append(colour_bgr[(away > 1.2 * radius + 0.5) & (away < 2.6 * radius + 2.0)])
        ring = weakest[(away > 1.1 * radius) & (away <= 1.35 * radius + 0.5)]
        beyond = weakest[(away > 1.9 * radius) & (away < 2.6 * radius + 1.0)]
        if len(ring) and len(beyond):
            whiter.append(float(np.median(ring)) / max(float(np.median(beyond)), 1.0))
    discs, rest = np.concatenate(inside).astype(np.float64), np.concatenate(around).astype(np.float64)
    if len(discs) < _FEWEST or len(rest) < _FEWEST:
        raise Refused("picture of the marker", "cut too close", "with its surround", "show more around it")
    return colour_model(name, discs, rest, ring=float(np.median(whiter or [0.0])) >= _RINGED)


def _distances(colour_bgr: Image, u: float, v: float) -> Float64:
    """Distance of every pixel from a place, shape (H, W)."""
    rows, columns = np.ogrid[: colour_bgr.shape[0], : colour_bgr.shape[1]]
    return np.hypot(columns - u, rows - v)


def _radius(colour_bgr: Image, away: Float64) -> float:
    """Radius at which what is about the click is as much changed as unchanged."""
    pixels = colour_bgr.astype(np.float64)
    brightness = pixels.sum(axis=2, keepdims=True) + 30.0
    features = np.concatenate([pixels / brightness, 0.3 * np.log(brightness)], axis=2)
    seed = np.median(features[away <= _SEED_PX], axis=0)
    change = np.linalg.norm(features - seed, axis=2)
    circles = [np.abs(away - r) <= 0.75 for r in range(1, 2 * _LARGEST_PX)]
    profile = np.array([np.median(change[circle]) for circle in circles if circle.any()])
    edge = profile[:_LARGEST_PX]
    first = np.flatnonzero(edge > max(_EDGE, 0.5 * _plateau(profile)))
    if not len(first):
        raise Refused(
            "click",
            "on a surface without an edge",
            "on a coloured disc",
            "click the middle of a marker's disc",
        )
    return float(first[0]) + 0.5


def _plateau(profile: Float64) -> float:
    """Change just outside the disc: the first peak of the profile."""
    rising = np.flatnonzero(np.diff(profile) < -0.02)
    rising = rising[profile[rising] > _EDGE]
    return float(profile[rising[0]] if len(rising) else profile.max())
