"""Where takes come from: recordings of other programs, and cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from rehab_app import __version__
from rehab_app.calibration import CalibratedCamera, rectified, views_of
from rehab_app.cameras import Camera, Outage, virtual_camera
from rehab_app.errors import Refused
from rehab_app.geometry.view import View
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.hand.subject import Subject
from rehab_app.recording.buffered import Buffered
from rehab_app.recording.importers import import_recording
from rehab_app.recording.live_pose import LivePose
from rehab_app.recording.recorder import RecordedTake, TakeOrder
from rehab_app.recording.recorder import record_take as record_from
from rehab_app.services.recording_request import LIVE_KINDS, VIRTUAL, RecordingRequest
from rehab_app.tracking import Tracker, make_tracker
from rehab_app.tracking.bare_hand import PROTOCOL as BARE_HAND
from rehab_app.vision import Detector, colour_from_json, make_detector

SUBJECT = "virtual-therapist"
CYCLE_S = 4.0


@dataclass(frozen=True, slots=True)
class Recorded:
    """A new take file.

    Attributes:
        path: The sealed file.
        landmarks: Markers per frame.
        frames: Number of frames.
        gaps: Spans in which some marker was not seen.
        taken: What the recorder says of it; None of an imported one.
    """

    path: Path
    landmarks: int
    frames: int
    gaps: int
    taken: RecordedTake | None = None


@dataclass(frozen=True, slots=True)
class Listeners:
    """Who is told of a recording while it runs.

    Attributes:
        on_frame: Told of every frame, on the recording's thread; it must not take long.
        on_outage: Told while the camera gives nothing.
        finished: Asked at every frame whether to end early.
    """

    on_frame: Callable[[LivePose], None] | None = None
    on_outage: Callable[[Outage], None] | None = None
    finished: Callable[[], bool] | None = None


def import_take(path: Path, side: str, protocol: str | None, target: Path) -> Recorded:
    """Turn a recording of another program into a take file.

    Args:
        path: The recording.
        side: Side of the hand; empty for the one that the file states, else right.
        protocol: Marker protocol, None to recognise a built-in one by its names.
        target: The take file.

    Raises:
        Refused: The recording cannot become a take; nothing is left at ``target``.
    """
    named = Path(protocol) if protocol is not None and protocol.endswith(".toml") else protocol
    taken = import_recording(path, side, named)
    exercise = Path(path.name.removesuffix(".lz")).stem
    sealed = taken.write(target, exercise=exercise, software_version=__version__)
    return Recorded(sealed.path, taken.landmarks, taken.frames, taken.gaps)


def record_take(
    request: RecordingRequest,
    target: Path,
    *,
    calibrations: tuple[CalibratedCamera | None, ...],
    subject: Subject | None,
    listeners: Listeners,
) -> Recorded:
    """Record a take from a camera, or from several that are calibrated to each other.

    Args:
        request: What to record.
        target: The take file.
        calibrations: Of each camera; None where it was never calibrated, or states its own.
        subject: The person's hand, if known already.
        listeners: Who is told meanwhile.

    Raises:
        Refused: The camera cannot be used, no hand was seen, the take came out shorter than 1 s, or it cannot
            be written; no file is left then.
    """
    protocol = load_protocol(request.protocol)
    calibration = calibrations[0]
    views = _views(request, calibrations)
    cameras = [_camera(request, protocol, calibration)]
    cameras += [_real(spec, known) for spec, known in zip(request.beside, calibrations[1:], strict=True)]
    virtual = request.camera == VIRTUAL
    order = TakeOrder(
        target,
        request.side,
        request.exercise,
        request.seconds,
        __version__,
        request.person or (SUBJECT if virtual else ""),
        request.consent_images,
        "" if calibration is None else calibration.digest,
        request.station,
    )
    detector, tracker = _eyes(request, protocol, cameras, calibration, subject)
    taken = record_from(
        cameras,
        protocol,
        order,
        tracker=tracker,
        detector=detector,
        views=views,
        on_frame=listeners.on_frame,
        on_outage=listeners.on_outage,
        finished=listeners.finished,
    )
    return Recorded(taken.path, taken.landmarks, taken.frames, taken.gaps, taken)


def _camera(
    request: RecordingRequest, protocol: MarkerProtocol, calibration: CalibratedCamera | None
) -> Camera:
    if request.camera != VIRTUAL:
        return _real(request.camera, calibration)
    return virtual_camera(
        request.exercise,
        request.side,
        request.seconds,
        protocol,
        seed=request.seed,
        period_s=CYCLE_S,
        realtime=request.realtime,
    )


def _real(spec: str, calibration: CalibratedCamera | None) -> Camera:
    from rehab_app.cameras import open_camera

    opened = open_camera(spec, intrinsics=None if calibration is None else calibration.intrinsics)
    live = spec.partition(":")[0] in LIVE_KINDS
    return rectified(Buffered(opened) if live else opened, calibration)


def _views(request: RecordingRequest, calibrations: tuple[CalibratedCamera | None, ...]) -> tuple[View, ...]:
    """Where the cameras stand."""
    known = tuple(one for one in calibrations if one is not None)
    if len(calibrations) > 1 and len(known) < len(calibrations):
        missing = (request.camera, *request.beside)[[one is None for one in calibrations].index(True)]
        raise Refused(
            f"camera {missing}",
            "of unknown place",
            "calibrated together with the others",
            "run rehab-app calibrate stereo with all of them, or record from one camera",
        )
    return views_of(known)


def _eyes(
    request: RecordingRequest,
    protocol: MarkerProtocol,
    cameras: Sequence[Camera],
    calibration: CalibratedCamera | None,
    subject: Subject | None,
) -> tuple[Detector, Tracker]:
    """What finds and what names the points of a hand: markers that it wears, or landmarks of a bare one."""
    if protocol.name == BARE_HAND:
        from rehab_app.recording.markerless import bare_hand

        metric = all(camera.has_depth for camera in cameras)
        return bare_hand(request.side, metric=metric, subject=subject)
    tracker = make_tracker(request.tracker, protocol, request.side, subject=subject, seed=request.seed)
    return _detector(protocol, calibration), tracker


def _detector(protocol: MarkerProtocol, calibration: CalibratedCamera | None) -> Detector:
    """The detector for the colour that was learnt with the camera, else for the protocol's."""
    if calibration is not None and calibration.colour:
        return make_detector(colour=colour_from_json(calibration.colour))
    colours = sorted({marker.colour for marker in protocol.markers} - {""})
    return make_detector(colour=colours[0]) if colours else make_detector()


def worth_keeping(taken: RecordedTake) -> bool:
    """Whether the hand that a recording learnt is good enough to begin the next one with."""
    return taken.measured_share > 0.8 and taken.residual_m < 0.005
