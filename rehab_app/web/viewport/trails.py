"""The paths that the fingertips have just made, as line segments of a fixed number."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.web.viewport.palette import Look
from robot_iface.kinematics import HandGeometry, forward
from robot_iface.types import Float64

POINTS = 31
_TIPS = np.array([3, 7, 11, 15, 19])


class Trails:
    """Five trails of one hand, solid or dashed.

    Args:
        server: The viser server.
        name: Scene node.
        look: Colour and dash.
    """

    def __init__(self, server: viser.ViserServer, name: str, look: Look) -> None:
        self._dashed = look.dashed
        self._points_m: Float64 = np.full((POINTS, 5, 3), np.nan)
        self._lines: Any = server.scene.add_line_segments(
            name,
            np.zeros((5 * (POINTS - 1), 2, 3), dtype=np.float32),
            look.trail,
            thickness=3.0 if look.dashed else 3.5,
            thickness_units="screen",
        )

    def clear(self) -> None:
        """Forget the past."""
        self._points_m[:] = np.nan
        self._draw()

    def add(self, geometry: HandGeometry, joints_rad: Float64) -> None:
        """Append the fingertips of one posture, (21,) rad."""
        self._points_m[:-1] = self._points_m[1:]
        self._points_m[-1] = forward(geometry, joints_rad).landmarks_m[_TIPS]
        self._draw()

    def replace(self, geometry: HandGeometry, joints_rad: Float64) -> None:
        """Show the fingertips of these postures, oldest first, (n <= POINTS, 21) rad."""
        self._points_m[:] = np.nan
        if len(joints_rad):
            self._points_m[-len(joints_rad) :] = forward(geometry, joints_rad).landmarks_m[:, _TIPS]
        self._draw()

    def show(self, visible: bool) -> None:
        """Show or hide the trails."""
        self._lines.visible = visible

    def _draw(self) -> None:
        starts, ends = self._points_m[:-1], self._points_m[1:].copy()
        if self._dashed:
            ends = starts + 0.5 * (ends - starts)
        lines = np.stack([starts, ends], axis=2)
        missing = ~np.isfinite(lines).all(axis=(2, 3))
        # what has not happened yet is drawn as segments without length at the newest point
        newest = np.nan_to_num(self._points_m[-1])
        lines[missing] = np.broadcast_to(newest[:, None], (5, 2, 3))[np.nonzero(missing)[1]]
        self._lines.points = lines.reshape(-1, 2, 3).astype(np.float32)
