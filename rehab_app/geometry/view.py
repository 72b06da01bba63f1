"""Where a camera stands beside the tracking camera, in whose frame everything is expressed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class View:
    """Pose of one of several cameras: ``T_tracking_camera``.

    Attributes:
        index: Number of the camera; 0 is the tracking camera itself.
        rotation_tracking_camera: Rotation from this camera's frame to the tracking camera's, shape (3, 3).
        p_tracking_camera_m: Optical centre in the tracking camera's frame, shape (3,).
    """

    index: int
    rotation_tracking_camera: Float64
    p_tracking_camera_m: Float64


PRIMARY = View(0, np.eye(3), np.zeros(3))
"""The tracking camera: its own frame, unmoved."""
