"""Names for detections that lie in a file: the tracker run over all of its frames."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.protocol import SEEN_PROTOCOLS, MarkerProtocol, load_protocol
from rehab_app.recording.detections_file import DetectionsFile, read_detections
from rehab_app.recording.labels import check_labels
from rehab_app.recording.progress import Progress
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.recording.track_sink import TrackSink
from rehab_app.tracking import Labels, Tracker, make_tracker
from sessions.errors import Refused
from sessions.records import Side

SOURCE = "detections-npz"
_NEAR_PX = 12.0
_OFTEN = 0.1  # share of the frames from which a complaint of the tracker is told
_FEWEST_COMPLAINTS = 15


def protocol_for(file: DetectionsFile, named: str | None) -> MarkerProtocol:
    """The protocol that was asked for, else the one that has all the names of the labels.

    Raises:
        Refused: There is no such protocol, or a label has a name that it does not know.
    """
    names = set(file.labels.names) if file.labels else set[str]()
    if named is None:
        known = [load_protocol(name) for name in SEEN_PROTOCOLS]
        # all of its names, else some of the usual protocol's, else some of any other's
        fits = [one for one in known if names and names == set(one.names)]
        fits += [one for one in known if names <= set(one.names)]
        protocol = (fits or known)[0]
    else:
        protocol = load_protocol(named)
    strange = sorted(names - set(protocol.names))
    if strange:
        raise Refused(
            f"recording {file.name}, init_name",
            f"naming {', '.join(strange[:5])}",
            f"markers of {protocol.name}: {', '.join(protocol.names)}",
            "rename them, or name another --protocol",
        )
    return protocol


def track_points(order: TrackOrder, progress: Progress) -> TrackResult:
    """Track a file of detections.

    Raises:
        Refused: The file is no such file, or no hand was ever found; one sentence says why.
    """
    source = order.inputs[0]
    if len(order.inputs) > 1:
        raise Refused(
            "input", f"{len(order.inputs)} files", "one file of detections", "join the cameras by view"
        )
    if order.overlay is not None:
        raise Refused("--overlay", "asked for", "left out for detections, which have no pictures", "drop it")
    if order.cameras:
        raise Refused("--camera-intrinsics", "given", "left out: the detections state theirs", "drop it")
    file = read_detections(source)
    if order.labels is not None:
        file = replace(file, labels=order.labels)
    protocol = protocol_for(file, order.protocol)
    first = file.cameras[0].intrinsics
    if order.labels is not None:
        check_labels(order.labels, protocol, first)
    tracker = make_tracker(
        order.tracker, protocol, order.side, subject=order.subject, labels=file.labels, seed=order.seed
    )
    with TrackSink(order, protocol, first, SOURCE) as sink:
        spent_s, said = _run(file, tracker, sink, progress)
        if not sink.enough(tracker.subject):
            raise _never_found(file, protocol, order.side, tracker)
        finished = sink.finish(tracker.subject, file.t_s)
        return sink.result(
            finished,
            dropped=0,
            ms_per_frame=1e3 * spent_s / len(file.t_s),
            complaints=(*file.complaints, *_of_labels(file, protocol), *said),
        )


def _run(
    file: DetectionsFile, tracker: Tracker, sink: TrackSink, progress: Progress
) -> tuple[float, tuple[str, ...]]:
    """Hand every frame to the tracker; the time that it took, s, and what it complained of for long."""
    spent_s = 0.0
    said: Counter[str] = Counter()
    for index, (detections, rows) in enumerate(file.captures()):
        sink.saw(detections.t_capture_ns, rows)
        start_s = time.perf_counter()
        understood = tracker.observe(detections)
        spent_s += time.perf_counter() - start_s
        sink.understood(understood, tracker.subject)
        said[tracker.complaint or ""] += 1
        progress(index + 1, len(file.t_s))
    sink.understood(tracker.finish(), tracker.subject)
    often = max(_FEWEST_COMPLAINTS, _OFTEN * len(file.t_s))
    return spent_s, tuple(text for text, count in said.items() if text and count >= often)


def _of_labels(file: DetectionsFile, protocol: MarkerProtocol) -> list[str]:
    """Sentences on labels that are missing, or that point at nothing."""
    if file.labels is None:
        return ["No marker is named in frame 0 (init_name): the names come from the open hand."]
    said: list[str] = []
    missing = [name for name in protocol.names if name not in file.labels.names]
    if missing:
        said.append(
            f"{len(missing)} of {len(protocol.names)} markers are not named in frame 0: {', '.join(missing)}."
        )
    first, _ = next(iter(file.captures()))
    alone = _without_detection(file.labels, first)
    if alone:
        said.append(
            f"In frame 0 nothing was detected where these markers were pointed at: {', '.join(alone)}."
        )
    return said


def _without_detection(labels: Labels, first: Detections) -> list[str]:
    """Names whose pixel has no detection of the first camera near it."""
    pixel = first.pixel_px[first.view == 0]
    if not len(pixel):
        return list(labels.names)
    apart = np.linalg.norm(labels.pixel_px[:, None] - pixel, axis=2).min(axis=1)
    return [name for name, far in zip(labels.names, apart > _NEAR_PX, strict=True) if far]


def _never_found(file: DetectionsFile, protocol: MarkerProtocol, side: Side, tracker: Tracker) -> Refused:
    most = int(np.bincount(file.frame, minlength=1).max())
    why = (tracker.complaint or f"at most {most} detections in a frame").rstrip(".")
    return Refused(
        f"recording {file.name}",
        f"without a hand that could be understood ({why})",
        f"an open {side} hand with the {len(protocol.names)} markers of {protocol.name}",
        "check --side and --protocol, or name the markers of frame 0 in init_name",
    )
