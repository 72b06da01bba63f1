"""From frames to a tracked hand: detect where the tracker expects, associate, fit; and a look at it live."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rehab_app.cameras import Camera, Frame, Outage
from rehab_app.geometry.detections import Detections, joined
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.recording.live_pose import LivePose
from rehab_app.recording.quality import Quality
from rehab_app.recording.together import Instant, together
from rehab_app.tracking import TrackedHand, Tracker
from rehab_app.vision import Detector
from rehab_app.vision.exposure import PictureWatch
from sessions.records import Status
from sessions.records.fields import Float64

_WATCH_EVERY = 3  # captures between two looks at whether the picture is any good


@dataclass(frozen=True, slots=True)
class Seen:
    """What one instant led to.

    Attributes:
        instant: The frames.
        detections: Markers found in them.
        tracked: Captures understood by it, oldest first; see ``Tracker.observe``.
        live: The newest of them, for a page.
    """

    instant: Instant
    detections: Detections
    tracked: tuple[TrackedHand, ...]
    live: LivePose

    @property
    def frame(self) -> Frame:
        """The frame that is shown: of the first camera that has one."""
        return self.instant.shown


class Pipeline:
    """Cameras to a tracked hand, one instant at a time.

    Args:
        detector: Finds markers.
        tracker: Names them and fits the hand.
        views: Where each camera stands; the first is the tracking camera.
    """

    def __init__(
        self,
        detector: Detector,
        tracker: Tracker,
        views: Sequence[View] = (PRIMARY,),
    ) -> None:
        self._detector = detector
        self._views = tuple(views)
        self._watch = PictureWatch()
        self._fault = ""
        self._quality = Quality()
        self.tracker = tracker

    def run(self, cameras: Sequence[Camera], until: Callable[[Frame], bool]) -> Iterator[Seen | Outage]:
        """Instants of open cameras until ``until`` says of one that it is beyond the end.

        Args:
            cameras: One for each view, open.
            until: Asked of the frame that is shown.
        """
        first_ns: int | None = None
        dropped = index = 0
        for instant in together(cameras):
            if isinstance(instant, Outage):
                yield instant
                continue
            frame = instant.shown
            if until(frame):
                return
            first_ns = frame.t_capture_ns if first_ns is None else first_ns
            dropped += instant.dropped
            if index % _WATCH_EVERY == 0:
                self._fault = self._watch.fault(frame.colour_bgr, frame.depth_m) or ""
            detections = self._detect(instant)
            tracked = self.tracker.observe(detections)
            for one in tracked:
                self._quality.add(one)
            t_s = 1e-9 * (frame.t_capture_ns - first_ns)
            live = self._live(instant, detections, tracked, t_s, index, dropped)
            yield Seen(instant, detections, tracked, live)
            index += 1

    def _detect(self, instant: Instant) -> Detections:
        around = self.tracker.expected_m
        found = [
            self._detector.detect(
                frame.t_capture_ns,
                frame.colour_bgr,
                frame.depth_m,
                frame.intrinsics,
                None if around is None else _in_view(around, view),
                view,
            )
            for frame, view in zip(instant.frames, self._views, strict=True)
            if frame is not None
        ]
        return found[0] if len(found) == 1 else joined(found)

    def _live(
        self,
        instant: Instant,
        detections: Detections,
        tracked: tuple[TrackedHand, ...],
        t_s: float,
        index: int,
        dropped: int,
    ) -> LivePose:
        frame, camera = instant.shown, self._views[instant.camera].index
        last = tracked[-1] if tracked else None
        known = last is not None and bool(np.isfinite(last.pose.joints_rad).all())
        subject = self.tracker.subject
        lost, estimated, _ = self._quality.lately()
        found = min(len(detections) / len(self.tracker.marker_names), 1.0)
        return LivePose(
            t_ns=frame.t_capture_ns,
            t_s=t_s,
            frame=index,
            state=self.tracker.state,
            joints_rad=last.pose.joints_rad if last and known else None,
            fingertips_palm_m=last.pose.fingertips_palm_m if last and known else None,
            geometry=None if subject is None else subject.geometry,
            quality=measured_share(last) if last else found,
            estimated=estimated,
            lost=lost,
            dropped=dropped,
            colour_bgr=frame.colour_bgr,
            marker_px=detections.pixel_px[detections.view == camera],
            fault=self._fault,
            complaint=self.tracker.complaint or "",
        )


def measured_share(tracked: TrackedHand) -> float:
    """Share of the markers that were measured, 0 to 1."""
    return float(np.mean(tracked.markers.status == Status.MEASURED))


def _in_view(p_tracking_m: Float64, view: View) -> Float64:
    """Points of the tracking camera's frame in that of a view's camera, shape (K, 3)."""
    return (p_tracking_m - view.p_tracking_camera_m) @ view.rotation_tracking_camera
