"""One capture as a page shows it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from rehab_app.cameras.frame import Colour
from rehab_app.tracking import TrackingState
from robot_iface.kinematics import HandGeometry
from sessions.records.fields import Float64

_MEASURED_BGR = (90, 220, 60)
_ESTIMATED_BGR = (40, 150, 250)


@dataclass(frozen=True, slots=True)
class LivePose:
    """One capture as a page shows it.

    Attributes:
        t_ns: Capture time, monotonic, ns.
        t_s: The same from the first capture, s.
        frame: Index of the capture among those received.
        state: What the tracker was doing.
        joints_rad: Joint angles, shape (21,); None while there are none.
        fingertips_palm_m: Fingertips, shape (5, 3); None while there are none.
        geometry: The person's hand, once learnt.
        quality: Share of the markers that were measured, 0 to 1.
        estimated: Share of the markers that was estimated in the last second.
        lost: Share of the markers that was lost in the last second.
        dropped: Captures lost so far.
        colour_bgr: The image, shape (H, W, 3); shared, not to be written to.
        marker_px: Markers found in the image, shape (K, 2).
        fault: What is wrong with the picture, one sentence; empty if nothing is.
        complaint: What keeps the tracker from its work, one sentence; empty if nothing does.
    """

    t_ns: int
    t_s: float
    frame: int
    state: TrackingState
    joints_rad: Float64 | None
    fingertips_palm_m: Float64 | None
    geometry: HandGeometry | None
    quality: float
    estimated: float
    lost: float
    dropped: int
    colour_bgr: Colour
    marker_px: Float64
    fault: str = ""
    complaint: str = ""

    @property
    def trouble(self) -> str:
        """What a person should do something about: of the picture first; empty if nothing."""
        return self.fault or self.complaint

    def jpeg(self, quality: int = 80) -> bytes:
        """The image with a ring around every marker: green once it has a name, orange before."""
        image = self.colour_bgr.copy()
        colour = _MEASURED_BGR if self.joints_rad is not None else _ESTIMATED_BGR
        for u, v in np.rint(8.0 * self.marker_px).astype(int):
            cv2.circle(image, (int(u), int(v)), 8 * 8, colour, 1, cv2.LINE_AA, 3)
        _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        return bytes(encoded)
