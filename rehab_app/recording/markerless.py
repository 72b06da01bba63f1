"""A bare hand in the pictures of a recording: seen in every frame, learnt from all of them, then fitted."""

from __future__ import annotations

import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

from rehab_app.cameras import Outage
from rehab_app.geometry.detections import Detections, joined
from rehab_app.geometry.view import View
from rehab_app.hand.subject import Subject
from rehab_app.recording.found_points import FoundPoints
from rehab_app.recording.overlay import draw_overlay
from rehab_app.recording.progress import Progress
from rehab_app.recording.take import SHORTEST_S, too_short
from rehab_app.recording.together import Instant, together
from rehab_app.recording.track_inputs import Recordings, open_recordings
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.recording.track_sink import TrackSink
from rehab_app.recording.writing import event
from rehab_app.tracking import TRACKERS
from rehab_app.tracking.bare_hand import PROTOCOL, BareHandTracker, bare_hand_protocol, learn_bare_hand
from rehab_app.vision.markerless import BareHandDetector
from sessions.errors import Refused
from sessions.records import Side

_FEWEST = 5  # sightings without which nothing can be learnt of a hand
_OFTEN = 0.05  # share of the frames from which a doubt is worth telling
_NO_SCALE = "The hand's size is the network's guess: joint angles hold, lengths in m are rough."


def asks_for_bare_hand(order: TrackOrder) -> bool:
    """Whether an order is for the landmarks of a bare hand, not for markers that are worn."""
    return order.protocol == PROTOCOL


def bare_hand(
    side: Side, *, metric: bool, subject: Subject | None = None, folder: Path | None = None
) -> tuple[BareHandDetector, BareHandTracker]:
    """Detector and tracker of a bare hand for a ``Pipeline``.

    Args:
        side: Side of the hand; never inferred.
        metric: Whether every camera has depth.
        subject: The person, if known already.
        folder: Where the networks lie; the user's cache if None.

    Raises:
        Refused: The networks or the library that runs them are not installed.
    """
    detector = BareHandDetector(side, folder)
    return detector, BareHandTracker(side, metric=metric, subject=subject, doubt=detector.doubt)


def track_bare_hand(order: TrackOrder, progress: Progress, folder: Path | None = None) -> TrackResult:
    """Track a bare hand in a recording; the file is whole or absent.

    Args:
        order: What to track; its detector and seed do not matter, nothing is random.
        progress: Told of every frame.
        folder: Where the networks lie; the user's cache if None.

    Raises:
        Refused: There is no hand, it is the other one than stated, another tracker is named, or the networks
            are not installed.
    """
    if order.tracker != TRACKERS[0]:
        raise Refused("tracker", repr(order.tracker), f"{TRACKERS[0]} for a bare hand", "leave --tracker out")
    if order.labels is not None:
        raise Refused("--label", "given", "left out for a bare hand, which wears no markers", "drop it")
    recordings = open_recordings(order)
    metric = all(camera.has_depth for camera in recordings.cameras)
    protocol = bare_hand_protocol(metric=metric)
    detector = BareHandDetector(order.side, folder)
    start_s = time.perf_counter()
    seen, dropped, doubts = _seen(detector, recordings, progress)
    _check(order, detector, seen)
    subject = order.subject or learn_bare_hand(seen, order.side, metric=metric)
    tracker = BareHandTracker(order.side, metric=metric, subject=subject)
    first = recordings.cameras[0]
    found = FoundPoints()
    with TrackSink(order, protocol, first.intrinsics, first.name, recordings.calibration_digest) as sink:
        for one in seen:
            sink.saw(one.t_capture_ns, found.add(sink.frames, one))
            sink.understood(tracker.observe(one), subject)
        for sentence in doubts:
            sink.note(event(seen[0].t_capture_ns, "markerless", sentence))
        ms = 1e3 * (time.perf_counter() - start_s) / len(seen)
        finished = sink.finish(subject, **found.arrays())
        if order.overlay is not None:
            draw_overlay(order.overlay, first, finished[0], protocol, progress)
        complaints = (*recordings.complaints, *([] if metric else [_NO_SCALE]), *doubts)
        return sink.result(finished, dropped=dropped, ms_per_frame=ms, complaints=complaints)


def _seen(
    detector: BareHandDetector, recordings: Recordings, progress: Progress
) -> tuple[list[Detections], int, tuple[str, ...]]:
    """Landmarks of every frame, frames that were lost, and what was odd for long enough to be told."""
    seen: list[Detections] = []
    doubts: Counter[str] = Counter()
    dropped = 0
    with ExitStack() as opened:
        for camera in recordings.cameras:
            opened.enter_context(camera)
        for instant in together(recordings.cameras):
            if isinstance(instant, Outage):
                continue
            dropped += instant.dropped
            seen.append(_detected(detector, instant, recordings.views))
            if (doubt := detector.doubt()) is not None:
                doubts[doubt] += 1
            progress(len(seen), recordings.frames)
    return seen, dropped, tuple(text for text, count in doubts.items() if count > _OFTEN * len(seen))


def _detected(detector: BareHandDetector, instant: Instant, views: tuple[View, ...]) -> Detections:
    found = [
        detector.detect(frame.t_capture_ns, frame.colour_bgr, frame.depth_m, frame.intrinsics, None, view)
        for frame, view in zip(instant.frames, views, strict=True)
        if frame is not None
    ]
    return found[0] if len(found) == 1 else joined(found)


def _check(order: TrackOrder, detector: BareHandDetector, seen: list[Detections]) -> None:
    """Refuse a recording that shows no bare hand, or the other one."""
    name = f"hand in recording {order.inputs[0].name}"
    count = sum(len(one) > 0 for one in seen)
    if count < _FEWEST:
        raise Refused(
            name,
            f"seen in {count} of {len(seen)} frames",
            f"a whole bare hand in {_FEWEST} frames or more",
            "film one hand, well lit, filling a quarter of the picture",
        )
    if detector.contradicted:
        share = round(100.0 * detector.contradictions / detector.sightings)
        other = "left" if order.side == "right" else "right"
        raise Refused(
            name,
            f"one that looks {other} in {share} % of the frames",
            f"a {order.side} hand, as stated",
            f"state --side {other}, or give a video that is not mirrored",
        )
    duration_s = 1e-9 * (seen[-1].t_capture_ns - seen[0].t_capture_ns)
    if order.makes_take and duration_s < SHORTEST_S:
        raise too_short(duration_s)
