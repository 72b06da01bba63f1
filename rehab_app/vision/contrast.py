"""How much more of a colour a pixel has than its surroundings."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Image = NDArray[np.uint8]


def over_surround(image: Float32, surround_px: int) -> Float32:
    """A pixel's value minus the mean over a window about it, shape (H, W).

    Args:
        image: Tint, shape (H, W).
        surround_px: Width of the window, odd.
    """
    return np.subtract(image, np.asarray(cv2.blur(image, (surround_px, surround_px)), np.float32))


def smoothed(image: Float32) -> Float32:
    """Mean over 3 by 3 pixels, shape (H, W)."""
    return np.asarray(cv2.blur(image, (3, 3)), np.float32)
