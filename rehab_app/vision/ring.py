"""The white ring around a disc: what tells a marker from any other spot of its colour."""

from __future__ import annotations

import numpy as np

from rehab_app.vision.contrast import Image
from sessions.records.fields import Float64

DIRECTIONS = 12
"""Directions in which the ring is looked for."""

_STRETCH = (1.15, 1.35, 1.55)
_BEYOND = (2.1, 2.6)
_OVER_INK = 0.66  # paper's weakest channel against the ink's strongest, whatever the light
_CLEARLY = 0.9
_OVER_OUTSIDE = 1.12
_NEUTRAL = 0.58  # and against its own strongest


def ring_share(colour_bgr: Image, ink_bgr: Float64, centre_px: Float64, rim_px: Float64) -> Float64:
    """Share of directions around each blob in which white paper is met, shape (B,).

    Paper is told by what it is beside the ink in the same light, so that shade and dim light do not matter.

    Args:
        colour_bgr: Colour image, shape (H, W, 3).
        ink_bgr: Mean colour of each blob, shape (B, 3).
        centre_px: Centres, shape (B, 2).
        rim_px: From each centre to its disc's rim in some directions, shape (B, D, 2); white just outside it,
            at any of three distances, counts.
    """
    sample = _around(colour_bgr, centre_px, rim_px, _STRETCH).astype(np.float64)
    outside = _around(colour_bgr, centre_px, rim_px, _BEYOND).min(axis=(1, 3)).astype(np.float64)
    weakest, strongest = sample.min(axis=-1), sample.max(axis=-1)
    ink = ink_bgr.max(axis=1)[:, None, None]
    white = (weakest > _OVER_INK * ink) & (weakest > _NEUTRAL * strongest)
    white &= sample.sum(axis=-1) > 1.15 * ink_bgr.sum(axis=1)[:, None, None]
    # beyond doubt paper, or at least whiter than what lies farther out: a bare spot on a grey wall is neither
    white &= (weakest > _CLEARLY * ink) | (weakest > _OVER_OUTSIDE * outside[:, None, :])
    return white.any(axis=1).mean(axis=-1)


def _around(colour_bgr: Image, centre_px: Float64, rim_px: Float64, stretch: tuple[float, ...]) -> Image:
    """Pixels about each centre at some multiples of its rim, shape (B, stretches, D, 3)."""
    height, width = colour_bgr.shape[:2]
    places = centre_px[:, None, None, :] + rim_px[:, None] * np.array(stretch)[:, None, None]
    column = np.clip(np.rint(places[..., 0]), 0, width - 1).astype(np.int64)
    row = np.clip(np.rint(places[..., 1]), 0, height - 1).astype(np.int64)
    return colour_bgr[row, column]
