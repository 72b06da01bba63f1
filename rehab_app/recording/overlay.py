"""A video with the tracks drawn over its pictures: what was measured, what is an estimate, what is lost."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from rehab_app.cameras import Camera, Frame
from rehab_app.cameras.frame import Colour
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.recording.progress import Progress
from rehab_app.recording.tracks import Tracks, check_tracks_target
from sessions.errors import Refused
from sessions.records import Status
from sessions.records.fields import Float64, UInt8

_MEASURED_BGR = (90, 220, 60)
_ESTIMATED_BGR = (40, 150, 250)
_LINK_BGR = (200, 200, 200)
_RADIUS_PX = 8
_DASHES = 4
_DASH_SHARE = 0.35
_SHIFT = 3
_CODECS = {".mp4": "mp4v", ".mkv": "mp4v", ".avi": "MJPG"}


def draw_overlay(
    path: Path, camera: Camera, tracks: Tracks, protocol: MarkerProtocol, progress: Progress
) -> None:
    """Play a recording once more and draw its tracks; the file is whole or absent.

    Measured markers are whole rings, estimates are dashed, lost ones are not drawn but counted.

    Args:
        path: Video to make.
        camera: The recording, not open; its first frame is that of the first track.
        tracks: The tracks, one row per frame.
        protocol: The markers and their links.
        progress: Told of the frames drawn.

    Raises:
        Refused: The video cannot be written, or its name is taken meanwhile.
    """
    working = path.with_name(f".{uuid.uuid4().hex[:8]}.{path.name}")
    known = camera.intrinsics
    codec = cv2.VideoWriter.fourcc(*_CODECS[path.suffix])
    rate_hz = min(max(camera.rate_hz, 1.0), 240.0)
    video = cv2.VideoWriter(str(working), codec, rate_hz, (known.width_px, known.height_px))
    try:
        if not video.isOpened():
            raise Refused(
                "--overlay", f"{path.name!r}, which cannot be written", "an .mp4 or .avi", "try .avi"
            )
        with camera:
            for index, frame in enumerate(_frames(camera, len(tracks.t_s))):
                video.write(drawn(frame.colour_bgr, tracks.pixel_px[index], tracks.status[index], protocol))
                progress(index + 1, len(tracks.t_s))
        video.release()
        check_tracks_target(path, "--overlay")
        working.rename(path)
    finally:
        video.release()
        working.unlink(missing_ok=True)


def drawn(image: Colour, pixel_px: Float64, status: UInt8, protocol: MarkerProtocol) -> Colour:
    """A copy of an image with links, rings and names.

    Args:
        image: Shape (H, W, 3).
        pixel_px: Where each marker is, NaN where it is lost, shape (M, 2).
        status: Status of each marker, shape (M,).
        protocol: The markers.
    """
    picture = image.copy()
    known = np.isfinite(pixel_px).all(axis=1) & (status != Status.LOST)
    bound = 4.0 * max(image.shape)  # a wild estimate must not overflow the drawing's integers
    known &= (np.abs(np.nan_to_num(pixel_px)) < bound).all(axis=1)
    row = {name: index for index, name in enumerate(protocol.names)}
    for index, marker in enumerate(protocol.markers):
        for link in marker.links:
            if known[index] and known[row[link]]:
                ends = (_fine(pixel_px[index]), _fine(pixel_px[row[link]]))
                cv2.line(picture, *ends, _LINK_BGR, 1, cv2.LINE_AA, _SHIFT)
    for index in np.flatnonzero(known):
        _ring(picture, pixel_px[index], measured=bool(status[index] == Status.MEASURED))
        _name(picture, pixel_px[index], protocol.names[index])
    counts = np.bincount(status, minlength=len(Status))
    words = "  ".join(f"{one.name.lower()} {counts[one]}" for one in reversed(Status))
    _words(picture, words, (8, 18), 0.5)
    return picture


def _frames(camera: Camera, most: int) -> Iterator[Frame]:
    count = 0
    for capture in camera.frames():
        if isinstance(capture, Frame):
            yield capture
            count += 1
            if count == most:
                return


def _fine(pixel_px: Float64) -> tuple[int, int]:
    """A pixel in the fixed-point numbers that the drawing takes."""
    u, v = np.rint(pixel_px * (1 << _SHIFT)).astype(int)
    return int(u), int(v)


def _ring(picture: Colour, pixel_px: Float64, *, measured: bool) -> None:
    radius = _RADIUS_PX << _SHIFT
    if measured:
        cv2.circle(picture, _fine(pixel_px), radius, _MEASURED_BGR, 2, cv2.LINE_AA, _SHIFT)
        return
    step = 360.0 / _DASHES
    for dash in range(_DASHES):
        cv2.ellipse(
            picture,
            _fine(pixel_px),
            (radius, radius),
            0.0,
            dash * step,
            (dash + _DASH_SHARE) * step,
            _ESTIMATED_BGR,
            2,
            cv2.LINE_AA,
            _SHIFT,
        )


def _name(picture: Colour, pixel_px: Float64, name: str) -> None:
    u, v = (int(value) for value in np.rint(pixel_px))
    _words(picture, name, (u + _RADIUS_PX + 2, v + 3), 0.32)


def _words(picture: Colour, words: str, place: tuple[int, int], size: float) -> None:
    """White words with a dark shadow, to be read over anything."""
    for colour, shift in (((0, 0, 0), 1), ((255, 255, 255), 0)):
        spot = (place[0] + shift, place[1] + shift)
        cv2.putText(picture, words, spot, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)
