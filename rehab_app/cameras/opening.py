"""The one place in which the name of a camera becomes a camera."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rehab_app.cameras.apart import Apart, reading
from rehab_app.cameras.frame import Camera
from rehab_app.cameras.freenect import FreenectCamera
from rehab_app.cameras.lease import CameraLease
from rehab_app.cameras.openni import OpenNiCamera
from rehab_app.cameras.realsense import RealSenseCamera
from rehab_app.cameras.reconnecting import Reconnecting
from rehab_app.cameras.recorded import RecordedCamera
from rehab_app.cameras.video import VideoCamera
from rehab_app.cameras.virtual_hand import virtual_camera
from rehab_app.cameras.webcam import Webcam
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import load_protocol
from sessions.errors import Refused

_FORMS = (
    "virtual, webcam:0, realsense, realsense:SERIAL, kinect:0, openni:0, video:FILE or session:FILE"
    " (or just the file)"
)
_VIRTUAL_S = 3600.0


def open_camera(spec: str, *, intrinsics: Intrinsics | None = None) -> Camera:
    """The camera of a name; it is opened by entering it.

    Live cameras come with their exclusive lease, survive being unplugged (``Reconnecting``), and their
    drivers run in a process of their own (``Apart``).

    Args:
        spec: As ``list_cameras`` names it; or ``video:FILE``, ``session:FILE``, or a file's path alone, where
            ``.mcap`` means a session. ``virtual:EXERCISE`` shows that exercise, ``virtual:EXERCISE:LEVEL`` at
            a difficulty.
        intrinsics: Camera of the images, for sources that state none, and the size to ask live cameras for;
            refused if it does not fit the images.

    Raises:
        Refused: There is no such camera or file, or it is of no use.
    """
    kind, _, rest = spec.partition(":")
    if kind in _LIVE:
        return _live(spec, kind, rest, intrinsics)
    if kind == "virtual":
        return _virtual(rest)
    if kind in ("video", "session") and rest:
        return _file(Path(rest), intrinsics, is_session=kind == "session")
    path = Path(spec)
    if spec and (path.suffix or path.exists()):
        return _file(path, intrinsics, is_session=path.suffix == ".mcap")
    raise Refused("camera", repr(spec), _FORMS, "see rehab-app camera list for what is there")


def live_source(spec: str, intrinsics: Intrinsics | None) -> Camera:
    """The live camera of a name itself, whose driver runs in the process that opens it.

    Raises:
        Refused: It cannot be read as the name of a camera, or the intrinsics are not for it.
    """
    kind, _, rest = spec.partition(":")
    return _LIVE[kind](spec, rest, intrinsics)


def _live(spec: str, kind: str, rest: str, intrinsics: Intrinsics | None) -> Camera:
    name = spec if rest or kind == "realsense" else f"{kind}:0"

    def make() -> Camera:
        return Apart(live_source(spec, intrinsics), reading(spec, intrinsics))

    return Reconnecting(make, CameraLease(name))


def _webcam(spec: str, rest: str, intrinsics: Intrinsics | None) -> Camera:
    return Webcam(_number(spec, rest), intrinsics)


def _realsense(spec: str, rest: str, intrinsics: Intrinsics | None) -> Camera:
    if intrinsics is None:
        return RealSenseCamera(rest or None)
    return RealSenseCamera(rest or None, size_px=(intrinsics.width_px, intrinsics.height_px))


def _kinect(spec: str, rest: str, intrinsics: Intrinsics | None) -> Camera:
    return FreenectCamera(_number(spec, rest), intrinsics)


def _openni(spec: str, rest: str, intrinsics: Intrinsics | None) -> Camera:
    return OpenNiCamera(rest if rest and not rest.isdecimal() else _number(spec, rest), intrinsics)


_LIVE: dict[str, Callable[[str, str, Intrinsics | None], Camera]] = {
    "webcam": _webcam,
    "realsense": _realsense,
    "kinect": _kinect,
    "openni": _openni,
}


def _virtual(rest: str) -> Camera:
    exercise, _, level = rest.partition(":")
    return virtual_camera(
        exercise or ("mixed" if level else "open_close"),
        "right",
        _VIRTUAL_S,
        load_protocol("thesis25"),
        realtime=True,
        level=level or None,
    )


def _file(path: Path, intrinsics: Intrinsics | None, *, is_session: bool) -> Camera:
    return RecordedCamera(path, intrinsics) if is_session else VideoCamera(path, intrinsics)


def _number(spec: str, rest: str) -> int:
    if not rest:
        return 0
    if rest.isascii() and rest.isdecimal() and len(rest) < 4:
        return int(rest)
    raise Refused("camera", repr(spec), _FORMS, "see rehab-app camera list for what is there")
