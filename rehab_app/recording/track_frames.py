"""Markers found, named and fitted in the pictures of a recording."""

from __future__ import annotations

import time
from contextlib import ExitStack

from rehab_app.calibration import Rectified
from rehab_app.cameras import Camera, Outage
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.recording.found_points import FoundPoints
from rehab_app.recording.labels import check_labels
from rehab_app.recording.noted import Noted
from rehab_app.recording.overlay import draw_overlay
from rehab_app.recording.pipeline import Pipeline
from rehab_app.recording.progress import Progress
from rehab_app.recording.track_inputs import Recordings, open_recordings
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.recording.track_sink import TrackSink
from rehab_app.recording.writing import no_hand
from rehab_app.tracking import Labels, make_tracker
from rehab_app.vision import colour_from_json, make_detector
from rehab_app.vision.port import Detector
from sessions.errors import Refused

DEFAULT_PROTOCOL = "thesis25"


def track_frames(order: TrackOrder, progress: Progress) -> TrackResult:
    """Track the pictures of one recording, or of several cameras together.

    Raises:
        Refused: A recording cannot be played, or no hand was ever found; one sentence says why.
    """
    protocol = load_protocol(order.protocol or DEFAULT_PROTOCOL)
    recordings = open_recordings(order)
    first = recordings.cameras[0]
    labels = _labels(order, protocol, first)
    tracker = make_tracker(
        order.tracker, protocol, order.side, subject=order.subject, labels=labels, seed=order.seed
    )
    pipeline = Pipeline(_detector(order, protocol, recordings), tracker, recordings.views)
    digest = recordings.calibration_digest
    with TrackSink(order, protocol, first.intrinsics, first.name, digest) as sink:
        noted, found = Noted(), FoundPoints()
        dropped, ms = _run(pipeline, recordings, sink, noted, found, progress)
        if not sink.enough(tracker.subject):
            raise _no_hand(order, protocol, sink, noted)
        finished = sink.finish(tracker.subject, **found.arrays())
        if order.overlay is not None:
            draw_overlay(order.overlay, recordings.cameras[0], finished[0], protocol, progress)
        return sink.result(
            finished,
            dropped=dropped,
            ms_per_frame=ms,
            complaints=(*recordings.complaints, *noted.sentences),
        )


def _run(
    pipeline: Pipeline,
    recordings: Recordings,
    sink: TrackSink,
    noted: Noted,
    found: FoundPoints,
    progress: Progress,
) -> tuple[int, float]:
    """Play the recordings; captures that they lost, and mean time of seeing and tracking, ms."""
    dropped = 0
    start_s = time.perf_counter()
    with ExitStack() as opened:
        for camera in recordings.cameras:
            opened.enter_context(camera)
        for seen in pipeline.run(recordings.cameras, lambda _: False):
            if isinstance(seen, Outage):
                continue
            dropped += seen.instant.dropped
            t_ns = seen.detections.t_capture_ns
            sink.saw(t_ns, found.add(sink.frames, seen.detections))
            sink.understood(seen.tracked, pipeline.tracker.subject)
            for event in noted.of(seen):
                sink.note(event)
            progress(sink.frames, recordings.frames)
    sink.understood(pipeline.tracker.finish(), pipeline.tracker.subject)
    return dropped, 1e3 * (time.perf_counter() - start_s) / max(sink.frames, 1)


def _labels(order: TrackOrder, protocol: MarkerProtocol, camera: Camera) -> Labels | None:
    """The markers that were named, where the rectified picture shows them."""
    if order.labels is None:
        return None
    check_labels(order.labels, protocol, camera.intrinsics)
    if not isinstance(camera, Rectified):
        return order.labels
    lens = camera.calibration.lens
    return Labels(order.labels.names, lens.undistorted(order.labels.pixel_px, camera.intrinsics))


def _detector(order: TrackOrder, protocol: MarkerProtocol, recordings: Recordings) -> Detector:
    """The detector for the markers' colour: as learnt with the calibration, else as the protocol says."""
    if learnt := order.colour or recordings.colour:
        return make_detector(order.detector, colour_from_json(learnt))
    colours = sorted({marker.colour for marker in protocol.markers} - {""})
    if not colours:
        raise Refused(
            f"marker protocol {protocol.name}",
            "of landmarks without a colour",
            "of markers that can be seen",
            "use mediapipe21 for a bare hand, thesis25 for markers, or state colours in the protocol",
        )
    return make_detector(order.detector, colours[0])


def _no_hand(order: TrackOrder, protocol: MarkerProtocol, sink: TrackSink, noted: Noted) -> Refused:
    name = order.inputs[0].name
    if not sink.frames:
        return Refused(f"recording {name}", "without frames", "a recording of a hand", "choose another file")
    return no_hand(order.side, protocol, noted.sentences)
