"""Pictures that cannot be worked with: one plain sentence that says what is wrong and what to do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.contrast import Image

_STEP = 8
_FROZEN_FRAMES = 15
_BLACK = 16
_DIM = 50
_WHITE = 250
_WHITE_SHARE = 0.4
_EVEN = 2.0
_GREY = 2
_DEPTH_SHARES = (0.002, 0.1)


def picture_fault(colour_bgr: Image, depth_m: NDArray[np.float32] | None) -> str | None:
    """What is wrong with a picture, in one sentence; None of a good one. Looks at every 64th pixel.

    Args:
        colour_bgr: Colour image, shape (H, W, 3).
        depth_m: Depth image, shape (H, W), 0 or NaN where there is none; None of a camera without depth.
    """
    colour = colour_bgr[::_STEP, ::_STEP]
    return _colour_fault(colour) or (None if depth_m is None else _depth_fault(depth_m[::_STEP, ::_STEP]))


class PictureWatch:
    """Watches pictures as they come: what ``picture_fault`` says, and whether they still change."""

    def __init__(self) -> None:
        self._last: bytes = b""
        self._same = 0

    def fault(self, colour_bgr: Image, depth_m: NDArray[np.float32] | None) -> str | None:
        """What is wrong with the newest picture, or with half a second of the same; None if nothing."""
        seen = colour_bgr[::_STEP, ::_STEP].tobytes()
        self._same = self._same + 1 if seen == self._last else 0
        self._last = seen
        found = picture_fault(colour_bgr, depth_m)
        if found is None and self._same >= _FROZEN_FRAMES:
            return "The camera sends the same picture again and again: unplug it and plug it in again."
        return found


def _colour_fault(colour: Image) -> str | None:
    """Fault of a thinned colour image, shape (h, w, 3)."""
    strongest = colour.max(axis=2)
    bright = float(np.quantile(strongest, 0.95))
    if bright < _BLACK:
        return "The picture is black: uncover the lens or switch the light on."
    if bright < _DIM:
        return "The picture is too dark to find markers: give more light or a longer exposure."
    if float((colour.min(axis=2) >= _WHITE).mean()) > _WHITE_SHARE:
        return "The picture is over-exposed: dim the light or shorten the exposure."
    if float(colour.std(axis=(0, 1)).max()) < _EVEN:
        return "The picture is one even tone: something covers the lens."
    spread = strongest.astype(np.int16) - colour.min(axis=2)
    if float(np.quantile(spread, 0.998)) <= _GREY:
        return "The picture has no colour: switch the camera from infrared or grey to colour."
    return None


def _depth_fault(depth_m: NDArray[np.float32]) -> str | None:
    """Fault of a thinned depth image, shape (h, w)."""
    share = float((depth_m > 0.0).mean())
    if share < _DEPTH_SHARES[0]:
        return "The camera gives no depth: check its cable; the hand is followed in the plane only."
    if share < _DEPTH_SHARES[1]:
        return "The camera gives hardly any depth: keep 0.5 to 1 m away and sunlight off the hand."
    return None
