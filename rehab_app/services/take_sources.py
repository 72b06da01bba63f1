"""Where takes come from: recordings of other programs, and the virtual camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rehab_app import __version__
from rehab_app.cameras import virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.importers import import_recording
from rehab_app.recording.pipeline import LivePose
from rehab_app.recording.recorder import TakeOrder
from rehab_app.recording.recorder import record_take as record_from
from sessions.records import Side

PROTOCOL = "thesis25"
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
    """

    path: Path
    landmarks: int
    frames: int
    gaps: int


def import_take(path: Path, side: str, protocol: str | None, target: Path) -> Recorded:
    """Turn a recording of another program into a take file.

    Args:
        path: The recording.
        side: Side of the hand.
        protocol: Marker protocol, None to recognise a built-in one by its names.
        target: The take file.

    Raises:
        Refused: The recording cannot become a take; nothing is left at ``target``.
    """
    named = Path(protocol) if protocol is not None and protocol.endswith(".toml") else protocol
    taken = import_recording(path, side, named)
    sealed = taken.write(target, exercise=path.stem, software_version=__version__)
    return Recorded(sealed.path, taken.landmarks, taken.frames, taken.gaps)


def record_take(
    exercise: str,
    side: Side,
    seconds: float,
    seed: int,
    target: Path,
    *,
    realtime: bool,
    on_frame: Callable[[LivePose], None] | None,
    finished: Callable[[], bool] | None,
) -> Recorded:
    """Record a take of the virtual therapist before the virtual camera.

    Args:
        exercise: One of the virtual camera's motions, repeated as often as ``seconds`` needs.
        side: Side of the hand.
        seconds: Length.
        seed: Seed of the camera's noise, the hand's sway and where the markers sit.
        target: The take file.
        realtime: Frames come at their time of capture.
        on_frame: Told of every frame.
        finished: Asked at every frame whether to end early.

    Raises:
        Refused: The take came out shorter than 1 s, or cannot be written; no file is left then.
    """
    protocol = load_protocol(PROTOCOL)
    camera = virtual_camera(exercise, side, seconds, protocol, seed=seed, period_s=CYCLE_S, realtime=realtime)
    order = TakeOrder(target, side, exercise, seconds, __version__, SUBJECT)
    taken = record_from(camera, protocol, order, on_frame=on_frame, finished=finished)
    return Recorded(taken.path, taken.landmarks, taken.frames, taken.gaps)
