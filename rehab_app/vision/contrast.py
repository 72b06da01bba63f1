"""How much bluer a pixel is than its surroundings, whatever the brightness of the light."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Image = NDArray[np.uint8]

_DARK = 60.0  # added to the brightness sum, so that noise in dark parts does not look like colour
_BLUE_MINUS_RED = np.array([[1.0, 0.0, -1.0]], dtype=np.float32)
_SUM = np.array([[1.0, 1.0, 1.0]], dtype=np.float32)


def chroma(colour_bgr: Image) -> Float32:
    """(B - R) / (B + G + R + 60), shape (H, W): about .45 on blue paper, 0 on white, -.2 on skin."""
    colour = colour_bgr.astype(np.float32)
    difference = np.asarray(cv2.transform(colour, _BLUE_MINUS_RED), np.float32)
    brightness = np.asarray(cv2.transform(colour, _SUM), np.float32)
    brightness += np.float32(_DARK)
    return np.divide(difference, brightness, out=difference)


def centre_surround(image: Float32, centre_px: int, surround_px: int) -> Float32:
    """Mean over a small window minus mean over a large one, shape (H, W).

    Args:
        image: Chroma, shape (H, W).
        centre_px: Width of the small window, odd.
        surround_px: Width of the large window, odd.
    """
    centre = np.asarray(cv2.blur(image, (centre_px, centre_px)), np.float32)
    centre -= np.asarray(cv2.blur(image, (surround_px, surround_px)), np.float32)
    return centre
