"""From frames to a tracked hand: detect where the tracker expects, associate, fit; and a look at it live."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from rehab_app.cameras import Camera, Frame
from rehab_app.cameras.frame import Colour
from rehab_app.geometry.detections import Detections
from rehab_app.tracking import TrackedHand, Tracker, TrackingState
from rehab_app.vision import MarkerDetector
from robot_iface.kinematics import HandGeometry
from sessions.records import Status
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
        dropped: Captures lost so far.
        colour_bgr: The image, shape (H, W, 3); shared, not to be written to.
        marker_px: Measured markers in the image, shape (K, 2).
    """

    t_ns: int
    t_s: float
    frame: int
    state: TrackingState
    joints_rad: Float64 | None
    fingertips_palm_m: Float64 | None
    geometry: HandGeometry | None
    quality: float
    dropped: int
    colour_bgr: Colour
    marker_px: Float64

    def jpeg(self, quality: int = 80) -> bytes:
        """The image with a ring around every marker: green once it has a name, orange before."""
        image = self.colour_bgr.copy()
        colour = _MEASURED_BGR if self.joints_rad is not None else _ESTIMATED_BGR
        for u, v in np.rint(8.0 * self.marker_px).astype(int):
            cv2.circle(image, (int(u), int(v)), 8 * 8, colour, 1, cv2.LINE_AA, 3)
        _, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        return bytes(encoded)


@dataclass(frozen=True, slots=True)
class Seen:
    """What one frame led to.

    Attributes:
        frame: The frame.
        detections: Markers found in it.
        tracked: Captures understood by it, oldest first; see ``Tracker.observe``.
        live: The newest of them, for a page.
    """

    frame: Frame
    detections: Detections
    tracked: tuple[TrackedHand, ...]
    live: LivePose


class Pipeline:
    """Camera to tracked hand, one frame at a time.

    Args:
        detector: Finds markers.
        tracker: Names them and fits the hand.
    """

    def __init__(self, detector: MarkerDetector, tracker: Tracker) -> None:
        self._detector = detector
        self.tracker = tracker

    def run(self, camera: Camera, until: Callable[[Frame], bool]) -> Iterator[Seen]:
        """Frames of an open camera until ``until`` says of one that it is beyond the end."""
        first_ns: int | None = None
        dropped = 0
        for index, frame in enumerate(camera.frames()):
            if until(frame):
                return
            first_ns = frame.t_capture_ns if first_ns is None else first_ns
            dropped += frame.dropped
            detections = self._detector.detect(
                frame.t_capture_ns,
                frame.colour_bgr,
                frame.depth_m,
                frame.intrinsics,
                self.tracker.expected_m,
            )
            tracked = self.tracker.observe(detections)
            t_s = 1e-9 * (frame.t_capture_ns - first_ns)
            yield Seen(
                frame, detections, tracked, self._live(frame, detections, tracked, t_s, index, dropped)
            )

    def _live(
        self,
        frame: Frame,
        detections: Detections,
        tracked: tuple[TrackedHand, ...],
        t_s: float,
        index: int,
        dropped: int,
    ) -> LivePose:
        last = tracked[-1] if tracked else None
        known = last is not None and bool(np.isfinite(last.pose.joints_rad).all())
        subject = self.tracker.subject
        return LivePose(
            t_ns=frame.t_capture_ns,
            t_s=t_s,
            frame=index,
            state=self.tracker.state,
            joints_rad=last.pose.joints_rad if last and known else None,
            fingertips_palm_m=last.pose.fingertips_palm_m if last and known else None,
            geometry=None if subject is None else subject.geometry,
            quality=measured_share(last) if last else len(detections) / len(self.tracker.marker_names),
            dropped=dropped,
            colour_bgr=frame.colour_bgr,
            marker_px=detections.pixel_px,
        )


def measured_share(tracked: TrackedHand) -> float:
    """Share of the markers that were measured, 0 to 1."""
    return float(np.mean(tracked.markers.status == Status.MEASURED))
