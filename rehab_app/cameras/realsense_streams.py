"""Which streams of a RealSense camera to open: colour of one size, and depth at the same rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sessions.errors import Refused


@dataclass(frozen=True, slots=True)
class Streams:
    """The streams to open.

    Attributes:
        sensors: Sensors, each with the profiles to open it with.
        colour: Video profile of the colour stream.
    """

    sensors: tuple[tuple[Any, list[Any]], ...]
    colour: Any


def choose(rs: Any, device: Any, size_px: tuple[int, int], rate_hz: int, title: str) -> Streams:
    """The colour stream of a size, and the depth stream of that size or else the largest.

    Args:
        rs: The driver.
        device: The camera.
        size_px: Width and height of the colour image; depth is aligned to it anyway.
        rate_hz: Frames per second of both.
        title: What to call the camera in a refusal.

    Raises:
        Refused: The camera does not offer one of the two.
    """
    sensors = list(device.query_sensors())
    colours = _offered(sensors, rs.stream.color, (rs.format.bgr8, rs.format.rgb8), rate_hz)
    depths = _offered(sensors, rs.stream.depth, (rs.format.z16,), rate_hz)
    colour = next((item for item in colours if _size(item[1]) == size_px), None)
    depth = next((item for item in depths if _size(item[1]) == size_px), None)
    if depth is None and depths:
        depth = max(depths, key=lambda item: _size(item[1]))
    if colour is None or depth is None:
        kind, offered = ("colour", colours) if colour is None else ("depth", depths)
        sizes = sorted({_size(profile) for _, profile in offered})
        raise Refused(
            f"{kind} stream of the {title}",
            f"offered as {', '.join(f'{width} x {height}' for width, height in sizes) or 'none'}",
            f"{size_px[0]} x {size_px[1]} px at {rate_hz} Hz",
            "choose another camera",
        )
    if colour[0] == depth[0]:
        return Streams(((sensors[colour[0]], [colour[1], depth[1]]),), colour[1])
    return Streams(((sensors[colour[0]], [colour[1]]), (sensors[depth[0]], [depth[1]])), colour[1])


def _offered(
    sensors: list[Any], stream: Any, formats: tuple[Any, ...], rate_hz: int
) -> list[tuple[int, Any]]:
    """Number of the sensor and video profile of every matching stream, the preferred format first."""
    found = [
        (number, profile.as_video_stream_profile())
        for number, sensor in enumerate(sensors)
        for profile in sensor.get_stream_profiles()
        if profile.stream_type() == stream and profile.format() in formats and profile.fps() == rate_hz
    ]
    return sorted(found, key=lambda item: formats.index(item[1].format()))


def _size(profile: Any) -> tuple[int, int]:
    return int(profile.width()), int(profile.height())
