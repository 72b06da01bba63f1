"""What every tracker takes and gives; the port that the pipeline knows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from rehab_app.geometry.detections import Detections
from rehab_app.hand.subject import Subject
from sessions.records import HandPose, MarkerFrame
from sessions.records.fields import Float64, Int64

TrackingState = Literal["searching", "calibrating", "tracking", "lost"]


@dataclass(frozen=True, slots=True)
class TrackedHand:
    """One capture with names on its markers and the hand fitted to them.

    Attributes:
        markers: The markers in the order of the protocol.
        pose: The hand.
        detection: Row of the detection that each marker was given, -1 where none, shape (M,).
        state: What the tracker was doing.
    """

    markers: MarkerFrame
    pose: HandPose
    detection: Int64
    state: TrackingState


@dataclass(frozen=True, slots=True)
class Labels:
    """Names that a person (or a file) gave to markers in the first capture, by pointing at them.

    Attributes:
        names: The markers, all of the protocol or some.
        pixel_px: Where each was pointed at in the image of the tracking camera, shape (K, 2).
    """

    names: tuple[str, ...]
    pixel_px: Float64


class Tracker(Protocol):
    """Gives detections names, capture after capture."""

    @property
    def state(self) -> TrackingState:
        """What it is doing."""
        ...

    @property
    def marker_names(self) -> tuple[str, ...]:
        """Names of the M markers, in the order of every array."""
        ...

    @property
    def subject(self) -> Subject | None:
        """The person, once calibrated."""
        ...

    @property
    def expected_m(self) -> Float64 | None:
        """Where the markers are expected in the next capture, camera frame, (M, 3); None when unknown."""
        ...

    @property
    def complaint(self) -> str | None:
        """What keeps the hand from being tracked, one sentence for a person; None if nothing does."""
        ...

    def observe(self, detections: Detections) -> tuple[TrackedHand, ...]:
        """Take one capture, in the order of time.

        Returns:
            The captures that are now understood, oldest first: none while the tracker still learns the hand,
            then all that it held back (of a long wait the last seconds), then one each time.
        """
        ...

    def finish(self) -> tuple[TrackedHand, ...]:
        """Give up what is still held back, as no more captures come.

        Returns:
            Those captures, oldest first, as far as they are understood: as gaps where not at all.
        """
        ...
