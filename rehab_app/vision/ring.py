"""The white ring around a blue disc: what tells a marker from any other blue spot."""

from __future__ import annotations

import numpy as np

from rehab_app.vision.contrast import Float32, Image
from sessions.records.fields import Float64

_DIRECTIONS = 12
_ANGLES = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)
_STRETCH = (1.15, 1.35, 1.55)
_BRIGHT = 105
_COLOURLESS = 0.09


def ring_share(colour_bgr: Image, tint: Float32, centre_px: Float64, half_axes_px: Float64) -> Float64:
    """Share of directions around each blob in which white paper is met, shape (B,).

    Args:
        colour_bgr: Colour image, shape (H, W, 3).
        tint: Its chroma, shape (H, W).
        centre_px: Centres, shape (B, 2).
        half_axes_px: Half of each blob's image box along u and v, shape (B, 2); white just outside it, at any
            of three distances, counts.
    """
    height, width = tint.shape
    around = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
    reach = half_axes_px[:, None, None, :] * around[None, :, None, :] * np.array(_STRETCH)[:, None]
    places = centre_px[:, None, None, :] + reach
    column = np.clip(np.rint(places[..., 0]), 0, width - 1).astype(np.int64)
    row = np.clip(np.rint(places[..., 1]), 0, height - 1).astype(np.int64)
    white = (colour_bgr[row, column].min(axis=-1) > _BRIGHT) & (np.abs(tint[row, column]) < _COLOURLESS)
    return white.any(axis=-1).mean(axis=-1)
