"""A short look through a camera: what rate, light and depth it gives, and its last picture."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rehab_app.cameras.frame import Camera, Frame, Outage
from sessions.errors import Refused
from sessions.records.fields import Float64

SHORTEST_S, LONGEST_S = 0.1, 60.0
_WEIGHTS_BGR = np.array([0.114, 0.587, 0.299])
_STEP = 4


@dataclass(frozen=True, slots=True)
class Look:
    """What a camera gave while it was looked through.

    Attributes:
        camera: Its name.
        frames: How many frames came.
        rate_hz: Frames per second by their capture times; NaN of a single frame.
        width_px: Image width.
        height_px: Image height.
        depth_share: Share of the last picture's pixels with depth; None of a camera without depth.
        depth_m: Middle of that depth, m; None where there is none.
        brightness: Mean brightness of the last picture, 0 to 1.
        dropped: Captures lost meanwhile.
        outages: What the camera said while it gave nothing, each sentence once.
        last: The last frame.
    """

    camera: str
    frames: int
    rate_hz: float
    width_px: int
    height_px: int
    depth_share: float | None
    depth_m: float | None
    brightness: float
    dropped: int
    outages: tuple[str, ...]
    last: Frame


@dataclass(slots=True)
class _Seen:
    """What has been seen so far."""

    t_ns: list[int] = field(default_factory=list[int])
    dropped: int = 0
    outages: list[str] = field(default_factory=list[str])
    silent_ns: int | None = None
    last: Frame | None = None


def look_through(camera: Camera, seconds: float) -> Look:
    """Open a camera, look for some seconds of its own time, and close it.

    Args:
        camera: Not yet open.
        seconds: How long, 0.1 to 60 s, from the first frame; a recording may end before.

    Raises:
        Refused: The time is out of bounds, or the camera cannot be used or gives no frame in that time.
    """
    if not SHORTEST_S <= seconds <= LONGEST_S:
        bound = f"{SHORTEST_S:g} to {LONGEST_S:g} s"
        raise Refused("preview", f"{seconds:g} s long", bound, "choose another length")
    seen = _Seen()
    with camera:
        for capture in camera.frames():
            if isinstance(capture, Outage):
                over = _silent(seen, capture, seconds)
            else:
                over = _taken(seen, capture, seconds)
            if over:
                break
    return _summed(camera.name, seen)


def _taken(seen: _Seen, frame: Frame, seconds: float) -> bool:
    """Take note of a frame; whether that is enough."""
    seen.t_ns.append(frame.t_capture_ns)
    seen.dropped += frame.dropped
    seen.last, seen.silent_ns = frame, None
    return frame.t_capture_ns - seen.t_ns[0] >= seconds * 1e9


def _silent(seen: _Seen, outage: Outage, seconds: float) -> bool:
    """Take note of an outage; whether it has lasted as long as the look was to be."""
    if outage.reason not in seen.outages:
        seen.outages.append(outage.reason)
    seen.silent_ns = outage.t_ns if seen.silent_ns is None else seen.silent_ns
    return outage.t_ns - seen.silent_ns >= seconds * 1e9


def _summed(name: str, seen: _Seen) -> Look:
    if seen.last is None:
        why = f" ({seen.outages[-1]})" if seen.outages else ""
        raise Refused(f"camera {name}", f"without frames{why}", "giving frames", "choose another camera")
    spacing: Float64 = np.diff(np.array(seen.t_ns, np.float64))
    colour, depth = seen.last.colour_bgr[::_STEP, ::_STEP], seen.last.depth_m
    known = None if depth is None else depth[np.isfinite(depth) & (depth > 0.0)]
    return Look(
        camera=name,
        frames=len(seen.t_ns),
        rate_hz=1e9 / float(spacing.mean()) if len(spacing) else float("nan"),
        width_px=seen.last.intrinsics.width_px,
        height_px=seen.last.intrinsics.height_px,
        depth_share=None if depth is None or known is None else known.size / depth.size,
        depth_m=None if known is None or not known.size else float(np.median(known)),
        brightness=float((colour @ _WEIGHTS_BGR).mean() / 255.0),
        dropped=seen.dropped,
        outages=tuple(seen.outages),
        last=seen.last,
    )
