"""How like a marker each blob is: by size, ring and colour, held against the others of its picture.

Light, blur and the size of the stickers are the same for all markers of a picture. So a blob is compared with
the middle of those that look like markers at first sight, rather than with numbers that fit one camera only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.blobs import Blobs
from rehab_app.vision.colour import ColourModel
from rehab_app.vision.contrast import Image
from rehab_app.vision.ring import DIRECTIONS, ring_share
from sessions.records.fields import Float64

_SPREAD = 0.45  # of the logarithm of a half-hidden disc's size
_NOMINAL = (0.9, 1.0)  # size (blurred rims are trimmed) and ring of a marker, where too few others tell
_SIZES = (0.45, 1.4)  # stickers come smaller and larger than stated
_RINGS = (0.2, 0.3)
_RING_SHARE = 0.35
_VOICES = 5
_PLAIN = 0.15
_PLAIN_RING = 0.5
_ROUND = (0.8, 0.7)  # least roundness and ring of a disc that is seen whole, so must have its size
_WHOLE_OFF = 0.22
_FLAT_OFF = 0.45  # of pictures without depth, where nearer ones are larger
_FLOATING_OFF = 0.16
_FLOATING_RING = 0.45


@dataclass(frozen=True, slots=True)
class Likeness:
    """What is known of each blob.

    Attributes:
        size: Likeness of its size, 0 to 1, shape (B,); lower for discs that are partly hidden.
        similarity: Likeness in all, 0 to 1, shape (B,); 0 is no marker.
    """

    size: Float64
    similarity: Float64


def likeness(
    blobs: Blobs,
    colour_bgr: Image,
    model: ColourModel,
    expected_px: Float64,
    borne: NDArray[np.bool_],
    *,
    colour: float,
) -> Likeness:
    """Likeness of blobs to markers.

    A disc keeps the length of its longer axis however it is turned: shorter means partly hidden. A round blob
    in a whole ring is not hidden, so it must have its size; one that floats must look right.

    Args:
        blobs: Blobs of one image.
        colour_bgr: The image, shape (H, W, 3).
        model: The markers' colour.
        expected_px: Half axis of a whole disc at each blob's depth, NaN where unknown, shape (B,).
        borne: Whether there is a surface about each blob at its own depth, shape (B,).
        colour: Smallest cosine between a blob's chroma and the ink's.
    """
    if not len(blobs):
        return Likeness(np.zeros(0), np.zeros(0))
    mean = blobs.mean_of(colour_bgr)
    alike = model.is_like(mean) >= colour
    ring = np.ones(len(blobs))
    if model.ring:
        ring = ring_share(colour_bgr, mean, blobs.centre_px, blobs.rim_px(DIRECTIONS))
    ratio = _ratio(blobs.axes_px[:, 0], expected_px, alike & (ring >= _PLAIN_RING))
    plain = alike & (_size(ratio / _NOMINAL[0]) > _PLAIN) & (ring >= _RINGS[0]) & borne
    usual_size, usual_ring = _usual(ratio, ring, plain)
    off = np.abs(np.log(ratio / usual_size))
    good = alike & (ring >= np.clip(_RING_SHARE * usual_ring, *_RINGS))
    whole = (blobs.axes_px[:, 1] > _ROUND[0] * blobs.axes_px[:, 0]) & (ring > _ROUND[1])
    good &= ~whole | (off < np.where(np.isfinite(expected_px), _WHOLE_OFF, _FLAT_OFF))
    good &= borne | ((off < _FLOATING_OFF) & (ring > _FLOATING_RING * usual_ring))
    size = _size(ratio / usual_size)
    return Likeness(size, np.where(good, size * np.sqrt(np.minimum(ring / 0.8, 1.0)), 0.0))


def _ratio(length_px: Float64, expected_px: Float64, plausible: NDArray[np.bool_]) -> Float64:
    """Length over what is expected, shape (B,); without depth over the usual length of plausible blobs."""
    chosen = length_px[plausible] if plausible.any() else length_px
    usual = float(np.median(chosen)) / _NOMINAL[0]
    ratio = length_px / np.where(np.isfinite(expected_px), expected_px, usual)
    return np.maximum(ratio, 1e-3)


def _size(ratio: Float64) -> Float64:
    """Likeness of a size, 1 where the ratio is 1."""
    return np.exp(-((np.log(ratio) / _SPREAD) ** 2))


def _usual(ratio: Float64, ring: Float64, plain: NDArray[np.bool_]) -> tuple[float, float]:
    """Size and ring of the blobs that look like markers at first sight."""
    if plain.sum() < _VOICES:
        return _NOMINAL
    return float(np.clip(np.median(ratio[plain]), *_SIZES)), float(np.median(ring[plain]))
