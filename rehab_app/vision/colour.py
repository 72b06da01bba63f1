"""What colour a marker has: how its chroma differs from paper and skin, and over which hues it spreads."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from rehab_app.vision.contrast import Float32, Image
from sessions.errors import Refused
from sessions.records.fields import Float64, Int64

BINS = (24, 8)
"""Bins of hue and of saturation in a model's histogram."""

_CONTRAST = (
    0.42  # what the disc's centre stands out by in every model's tint: thresholds then fit all colours
)
_DARK = 30.0  # added to the brightness sum, so that noise in dark parts does not look like colour
_APART = 4.0  # squared deviations between ink and surround, below which a colour is none
_DARKER = 0.7  # least step of the logarithm of brightness from black ink to its surround
_NOISE = 0.03  # chroma of a surface wavers by so much anyway: no direction is trusted further than that
_INKS_BGR = {
    "blue": (196.0, 92.0, 34.0),
    "green": (70.0, 150.0, 45.0),
    "red": (45.0, 40.0, 200.0),
    "yellow": (35.0, 205.0, 235.0),
    "orange": (30.0, 120.0, 240.0),
    "purple": (150.0, 50.0, 120.0),
    "black": (34.0, 34.0, 34.0),
}
COLOURS = tuple(_INKS_BGR)
"""Colours that a protocol may name."""

_SURROUND_BGR = np.array(  # paper in cold and warm light, and skins from pale to dark
    [[238, 238, 238], [245, 236, 220], [218, 232, 242], [118, 152, 205], [150, 175, 220], [60, 85, 135]],
    dtype=np.float64,
)
_LIGHTS = np.array([0.45, 0.6, 0.8, 1.0, 1.2])


@dataclass(frozen=True, slots=True)
class ColourModel:
    """A marker's colour.

    Attributes:
        name: What a person calls it.
        ink_bgr: Colour of the disc in good light, 0 to 255.
        weights_bgr: Weights of B, G and R in the tint, before division by the brightness; their sum is 0.
        darkness: Weight of the lack of light in the tint: above 0 for black markers only.
        ring: Whether the disc lies in a white ring.
        histogram: Share of the disc's pixels in each bin of hue and saturation, ``BINS`` row by row.

    Raises:
        Refused: The numbers are not finite, do not fit together, or single out no colour.
    """

    name: str
    ink_bgr: tuple[float, float, float]
    weights_bgr: tuple[float, float, float]
    darkness: float
    ring: bool
    histogram: tuple[float, ...]

    def __post_init__(self) -> None:
        numbers = np.array([*self.ink_bgr, *self.weights_bgr, self.darkness, *self.histogram])
        thing = f"colour model {self.name}"
        if not np.isfinite(numbers).all() or len(self.histogram) != BINS[0] * BINS[1]:
            raise Refused(thing, "incomplete", f"finite with {BINS[0] * BINS[1]} bins", "learn it anew")
        if abs(sum(self.weights_bgr)) > 1e-6 or min(self.histogram) < 0 or self.darkness < 0:
            raise Refused(thing, "out of its bounds", "weights of sum 0, shares from 0 on", "learn it anew")
        if not (np.abs(self.weights_bgr).max() > 0 or self.darkness > 0):
            raise Refused(thing, "without any contrast", "a colour that stands out", "learn it anew")

    @property
    def shares(self) -> Float32:
        """The histogram, shape BINS, sum 1."""
        table = np.array(self.histogram, dtype=np.float32).reshape(BINS)
        return np.asarray(table / max(float(table.sum()), 1e-9), np.float32)

    def is_like(self, mean_bgr: Float64) -> Float64:
        """Cosine between the chroma of some colours and the ink's, (N, 3) to (N,); 1 for a black ink."""
        if self.darkness > 0:
            return np.ones(len(mean_bgr))
        own, other = _chroma(np.array([self.ink_bgr]))[0], _chroma(mean_bgr)
        length = np.linalg.norm(own) * np.linalg.norm(other, axis=1)
        return (other @ own) / np.maximum(length, 1e-9)


def named_colour(name: str) -> ColourModel:
    """The model that a colour's name stands for: flat ink in a white ring on skin.

    Raises:
        Refused: There is no such colour.
    """
    if name not in _INKS_BGR:
        known = ", ".join(COLOURS)
        raise Refused("marker colour", repr(name), f"one of {known}", "choose one, or learn the colour")
    ink = np.array(_INKS_BGR[name])
    flat = (ink * _LIGHTS[:, None]).repeat(40, axis=0)
    pixels = np.clip(flat + np.random.default_rng(0).normal(0.0, 5.0, flat.shape), 0, 255)
    return colour_model(name, pixels, (_SURROUND_BGR * _LIGHTS[:, None, None]).reshape(-1, 3), ring=True)


def colour_model(name: str, ink_bgr: Float64, surround_bgr: Float64, *, ring: bool) -> ColourModel:
    """A model from pixels of a disc and of what surrounds discs.

    The direction in chroma is Fisher's: it parts the disc from the surround while both vary. Where there is
    no colour, as on black, darkness takes its place.

    Args:
        name: What a person calls it.
        ink_bgr: Pixels of discs, shape (N, 3).
        surround_bgr: Pixels of paper and skin around them, shape (K, 3).
        ring: Whether the disc lies in a white ring.

    Raises:
        Refused: The disc does not stand out from its surround.
    """
    disc, rest = _chroma(ink_bgr), _chroma(surround_bgr)
    apart = disc.mean(axis=0) - rest.mean(axis=0)
    scatter = 0.5 * (np.cov(disc.T) + np.cov(rest.T)) + _NOISE**2 * np.eye(3)
    weights = np.linalg.solve(scatter, apart)
    weights -= weights.mean()
    distance = float(apart @ weights)
    middle = (
        float(np.median(ink_bgr[:, 0])),
        float(np.median(ink_bgr[:, 1])),
        float(np.median(ink_bgr[:, 2])),
    )
    darkness = 0.0
    if distance >= _APART:
        weights = weights * (_CONTRAST / distance)
    else:
        grey = float(np.linalg.norm(disc.mean(axis=0))) < 2.0 * _NOISE
        step = float(np.log((np.median(surround_bgr.sum(axis=1)) + _DARK) / (sum(middle) + _DARK)))
        if not grey or step < _DARKER:
            raise Refused(
                f"marker colour {name}",
                "hardly different from what surrounds it",
                "a colour that stands out",
                "click the middle of a marker's disc, or use markers of a stronger colour",
            )
        weights, darkness = np.zeros(3), _CONTRAST / step
    b, g, r = (float(weight) for weight in weights)
    return ColourModel(name, middle, (b, g, r), darkness, ring, _histogram(ink_bgr))


def tint(colour_bgr: Image, model: ColourModel) -> Float32:
    """How much each pixel has of a colour whatever the light, shape (H, W): .42 more on a disc than around.

    Args:
        colour_bgr: Image, shape (H, W, 3).
        model: The colour.
    """
    colour = colour_bgr.astype(np.float32)
    brightness = np.asarray(cv2.transform(colour, np.ones((1, 3), np.float32)), np.float32)
    brightness += np.float32(_DARK)
    if model.darkness > 0:
        dark = np.asarray(cv2.log(brightness), np.float32)
        dark *= np.float32(-model.darkness)
        return dark
    difference = np.asarray(cv2.transform(colour, np.array([model.weights_bgr], np.float32)), np.float32)
    return np.divide(difference, brightness, out=difference)


def colour_to_json(model: ColourModel) -> str:
    """A model as JSON, to be kept with a calibration."""
    fields: dict[str, object] = {
        "name": model.name,
        "ink_bgr": model.ink_bgr,
        "weights_bgr": model.weights_bgr,
        "darkness": model.darkness,
        "ring": model.ring,
        "histogram": model.histogram,
    }
    return json.dumps(fields)


def colour_from_json(text: str) -> ColourModel:
    """The model that ``colour_to_json`` wrote.

    Raises:
        Refused: The text does not hold one.
    """
    try:
        table: dict[str, Any] = json.loads(text)
        return ColourModel(
            str(table["name"]),
            _triple(table["ink_bgr"]),
            _triple(table["weights_bgr"]),
            float(table["darkness"]),
            bool(table["ring"]),
            tuple(float(share) for share in table["histogram"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise Refused("colour model", f"unreadable ({error})", "what was saved", "learn it anew") from error


def _triple(values: Any) -> tuple[float, float, float]:
    b, g, r = (float(value) for value in values)
    return b, g, r


def _chroma(colour_bgr: Float64) -> Float64:
    """Colour over brightness less its mean, (N, 3) to (N, 3): zero on grey, smaller in the dark."""
    return (colour_bgr - colour_bgr.mean(axis=1, keepdims=True)) / (
        colour_bgr.sum(axis=1, keepdims=True) + _DARK
    )


def _histogram(ink_bgr: Float64) -> tuple[float, ...]:
    """Shares of pixels (N, 3) over hue and saturation, a little smeared over neighbouring bins."""
    pixels = np.clip(np.rint(ink_bgr), 0, 255).astype(np.uint8)[None]
    counts = np.bincount(hue_saturation_bins(pixels).ravel(), minlength=BINS[0] * BINS[1]).reshape(BINS)
    smooth = counts + 0.25 * (np.roll(counts, 1, axis=0) + np.roll(counts, -1, axis=0))
    return tuple(float(share) for share in (smooth / smooth.sum()).ravel())


def hue_saturation_bins(colour_bgr: Image) -> Int64:
    """Bin of each pixel's hue and saturation in a model's histogram, (H, W, 3) to (H, W) of int."""
    hsv = np.asarray(cv2.cvtColor(colour_bgr, cv2.COLOR_BGR2HSV), np.int64)
    return (hsv[..., 0] * BINS[0] // 180) * BINS[1] + hsv[..., 1] * BINS[1] // 256
