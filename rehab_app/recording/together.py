"""Captures of several cameras at about the same time as one; of one camera, each by itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rehab_app.cameras import Camera, Capture, Frame, Outage


@dataclass(frozen=True, slots=True)
class Instant:
    """What the cameras saw at one instant.

    Attributes:
        frames: Frame of each camera by its number, None of one that saw nothing then; at least one is there.
    """

    frames: tuple[Frame | None, ...]

    @property
    def camera(self) -> int:
        """Number of the first camera that has a frame: the one that is shown."""
        return next(index for index, frame in enumerate(self.frames) if frame is not None)

    @property
    def shown(self) -> Frame:
        """The frame of the first camera that has one."""
        return next(frame for frame in self.frames if frame is not None)

    @property
    def dropped(self) -> int:
        """Captures lost just before, of the camera that lost most."""
        return max(frame.dropped for frame in self.frames if frame is not None)


def together(cameras: Sequence[Camera]) -> Iterator[Instant | Outage]:
    """Instants of open cameras that share a clock, until every one has ended.

    Frames no more than half a period of the first camera apart belong together. An outage of any camera is
    handed on, and the others go on without it.
    """
    running = [iter(camera.frames()) for camera in cameras]
    if len(running) == 1:
        for capture in running[0]:
            yield capture if isinstance(capture, Outage) else Instant((capture,))
        return
    half_ns = round(0.5e9 / cameras[0].rate_hz)
    waiting: list[Frame | None] = [None] * len(running)
    ended = [False] * len(running)
    while True:
        for index, source in enumerate(running):
            if waiting[index] is None and not ended[index]:
                capture: Capture | None = next(source, None)
                ended[index] = capture is None
                if isinstance(capture, Outage):
                    yield capture
                else:
                    waiting[index] = capture
        there = [frame.t_capture_ns for frame in waiting if frame is not None]
        if not there:
            if all(ended):
                return
            continue
        chosen = tuple(
            frame if frame is not None and frame.t_capture_ns <= min(there) + half_ns else None
            for frame in waiting
        )
        waiting = [None if taken else frame for frame, taken in zip(waiting, chosen, strict=True)]
        yield Instant(chosen)
