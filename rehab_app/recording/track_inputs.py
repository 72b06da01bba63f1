"""Recordings as cameras that play them: videos and RGB-D sessions, rectified where their lens is known."""

from __future__ import annotations

from dataclasses import dataclass

from rehab_app.calibration import CalibratedCamera, load_camera, rectified, views_of
from rehab_app.cameras import Camera
from rehab_app.cameras.recorded import RecordedCamera
from rehab_app.cameras.video import VideoCamera
from rehab_app.geometry.view import View
from rehab_app.recording.detections_file import NO_DEPTH
from rehab_app.recording.track_order import TrackOrder
from sessions.errors import Refused
from sessions.store.diskfile import SUFFIX

_ASSUMED = (
    "The camera is not calibrated: a usual field of view is assumed, so that sizes and distances are rough "
    "(give --camera-intrinsics)."
)


@dataclass(frozen=True, slots=True)
class Recordings:
    """Recordings to be tracked together.

    Attributes:
        cameras: They, as cameras that are not open yet.
        views: Where each stands.
        calibration_digest: Of the first one's calibration; empty where its recording states the camera.
        frames: Frames of the first, None where unknown.
        colour: JSON of the colour model of the markers, empty where none was learnt.
        complaints: What a person should know, one sentence each.
    """

    cameras: tuple[Camera, ...]
    views: tuple[View, ...]
    calibration_digest: str
    frames: int | None
    colour: str
    complaints: tuple[str, ...]


def open_recordings(order: TrackOrder) -> Recordings:
    """The inputs of an order.

    Raises:
        Refused: One cannot be played, or calibrations are missing, too many, or do not fit.
    """
    known = tuple(load_camera(path) for path in order.cameras)
    if known and len(known) != len(order.inputs):
        raise Refused(
            "--camera-intrinsics",
            f"{len(known)} files",
            f"one for each of {len(order.inputs)} inputs",
            "repeat the option in the order of the inputs",
        )
    if len(order.inputs) > 1 and not known:
        raise Refused(
            "cameras",
            f"{len(order.inputs)} without known places",
            "calibrated to each other",
            "run rehab-app calibrate stereo and give one --camera-intrinsics for each",
        )
    players = [_player(order, index) for index in range(len(order.inputs))]
    said = [] if any(one.has_depth for one in players) else [NO_DEPTH]
    if not known and any(isinstance(one, VideoCamera) for one in players):
        said.append(_ASSUMED)
    frames = players[0].frame_count or None
    cameras = tuple(
        rectified(player, known[index] if known else None) for index, player in enumerate(players)
    )
    return Recordings(
        cameras,
        views_of(known),
        known[0].digest if known else "",
        frames,
        _colour(known),
        tuple(said),
    )


def _player(order: TrackOrder, index: int) -> VideoCamera | RecordedCamera:
    path = order.inputs[index]
    if path.suffix == SUFFIX:
        return RecordedCamera(path)
    return VideoCamera(path)


def _colour(known: tuple[CalibratedCamera, ...]) -> str:
    return known[0].colour if known else ""
