"""What a RealSense camera states of its colour lens, and its images without the lens's distortion."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.frame import Colour, Depth, Frame
from rehab_app.geometry.pinhole import Intrinsics

_GRID_PX = 8  # lenses are smooth: the driver is asked at every eighth pixel only
_Map = NDArray[np.float32]


class Straightening:
    """Makes frames of a colour stream and the depth aligned to it, without lens distortion.

    Args:
        rs: The driver.
        profile: Video profile of the colour stream.
    """

    def __init__(self, rs: Any, profile: Any) -> None:
        stated: Any = profile.get_intrinsics()
        self.intrinsics = Intrinsics(
            float(stated.fx),
            float(stated.fy),
            float(stated.ppx),
            float(stated.ppy),
            int(stated.width),
            int(stated.height),
        )
        self._swap = profile.format() == rs.format.rgb8
        self._maps = _maps(rs, stated) if any(stated.coeffs) else None

    def frame(self, t_capture_ns: int, colour: Any, depth: Any, dropped: int) -> Frame:
        """The frame of two device frames, whose memory is copied."""
        image: Colour = np.array(colour.get_data(), np.uint8)
        if self._swap:
            image = np.ascontiguousarray(image[:, :, ::-1])
        metres: Depth = np.asarray(depth.get_data()).astype(np.float32) * np.float32(depth.get_units())
        if self._maps is not None:
            image = np.asarray(cv2.remap(image, *self._maps, cv2.INTER_LINEAR), np.uint8)
            metres = np.asarray(cv2.remap(metres, *self._maps, cv2.INTER_NEAREST), np.float32)
        return Frame(t_capture_ns, image, metres, self.intrinsics, dropped)


def _maps(rs: Any, stated: Any) -> tuple[_Map, _Map]:
    """Where each pixel of the straight image lies in the distorted one: u and v, each of shape (H, W)."""
    rows = np.arange(0, stated.height + _GRID_PX, _GRID_PX)
    columns = np.arange(0, stated.width + _GRID_PX, _GRID_PX)
    grid: NDArray[np.float32] = np.array(
        [
            [
                rs.rs2_project_point_to_pixel(
                    stated, [(u - stated.ppx) / stated.fx, (v - stated.ppy) / stated.fy, 1.0]
                )
                for u in columns
            ]
            for v in rows
        ],
        np.float32,
    )
    v, u = np.mgrid[0 : stated.height, 0 : stated.width].astype(np.float32) / _GRID_PX
    fine = [cv2.remap(np.ascontiguousarray(grid[..., axis]), u, v, cv2.INTER_LINEAR) for axis in (0, 1)]
    return np.asarray(fine[0], np.float32), np.asarray(fine[1], np.float32)
