"""A take file that grows as captures are understood, and the figures of what is in it."""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rehab_app.cameras import Frame
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject, subject_to_json
from rehab_app.recording.images import calibration_record, frame_records
from rehab_app.recording.quality import Quality
from rehab_app.recording.take import TakeRecorder
from rehab_app.tracking import TrackedHand
from sessions.errors import Refused
from sessions.records import Event, SessionHeader, Side, Topic
from sessions.records.topics import CAMERA_CALIBRATION
from sessions.store.diskfile import check_target
from sessions.timebase import Timebase

_PICTURES = 120  # captures whose pictures wait while the hand is learnt: some 80 MB


@dataclass(frozen=True, slots=True)
class TakeFacts:
    """What the header of a take says of how it came about.

    Attributes:
        path: The take file; must not exist.
        side: Side of the hand; never inferred.
        exercise: Name of the movement.
        software_version: Version of the application.
        source: What gave the captures, such as "virtual-camera".
        calibration_digest: Digest of the camera's calibration.
        subject_id: Pseudonym of the person, empty if unknown.
        consent_images: Whether images may be stored.
        parents: Digests of the files that it was made from.
        station: JSON of the station that records, and how its clock stands; may be empty.
    """

    path: Path
    side: Side
    exercise: str
    software_version: str
    source: str
    calibration_digest: str
    subject_id: str = ""
    consent_images: bool = False
    parents: tuple[str, ...] = ()
    station: str = ""


@dataclass(frozen=True, slots=True)
class WrittenTake:
    """A sealed take.

    Attributes:
        path: The file.
        sha256: Its digest.
        duration_s: From its first to its last capture.
        quality: What became of the markers.
    """

    path: Path
    sha256: str
    duration_s: float
    quality: Quality


class TakeWriting:
    """Opens the file with the first capture that is understood: its header states the hand.

    Args:
        facts: What the header says.
        protocol: Markers that the hand wears.

    Raises:
        Refused: The path cannot be written to.
    """

    def __init__(self, facts: TakeFacts, protocol: MarkerProtocol) -> None:
        check_target(facts.path)
        self._facts = facts
        self._protocol = protocol
        self._recorder: TakeRecorder | None = None
        self._events: list[Event] = []
        self._pictures: deque[tuple[tuple[Topic, Any], ...]] = deque(maxlen=_PICTURES)
        self._pictured = False
        self.quality = Quality()

    def take(self, tracked: tuple[TrackedHand, ...], subject: Subject | None, timebase: Timebase) -> None:
        """Append what was understood.

        Raises:
            Refused: The file cannot be written to.
        """
        if not tracked or subject is None:
            return
        if self._recorder is None:
            self._recorder = TakeRecorder(self._facts.path, self._header(subject, timebase))
        for one in tracked:
            self._recorder.add(one.markers, one.pose)
            self.quality.add(one)
        for event in self._events:
            self._recorder.note(event)
        self._events.clear()

    def note(self, event: Event) -> None:
        """Append an event; one from before the file began goes into it once it does."""
        if self._recorder is None:
            self._events.append(event)
        else:
            self._recorder.note(event)

    def picture(self, frame: Frame) -> None:
        """Append the images of a capture; of those from before the file began, the last four seconds wait.

        Raises:
            Refused: The header states no consent, or the file cannot be written to.
        """
        if self._recorder is None:
            self._pictures.append(tuple(frame_records(frame)))
            return
        self._recorder.write(self._waiting_pictures(frame))
        self._recorder.write(frame_records(frame))

    def _waiting_pictures(self, frame: Frame) -> Iterator[tuple[Topic, Any]]:
        """The camera and the pictures that waited for the file to begin, once."""
        if not self._pictured:
            self._pictured = True
            yield CAMERA_CALIBRATION, calibration_record(frame)
        while self._pictures:
            yield from self._pictures.popleft()

    def seal(self) -> WrittenTake:
        """Finish the file.

        Raises:
            Refused: No hand was ever understood, or the take is shorter than a second; no file is left then.
        """
        if self._recorder is None:
            raise no_hand(self._facts.side, self._protocol)
        duration_s = self._recorder.duration_s
        sealed = self._recorder.seal()
        return WrittenTake(sealed.path, sealed.sha256, duration_s, self.quality)

    def close(self) -> None:
        """Let go of the file; what is not sealed stays as a partial that can be recovered."""
        if self._recorder is not None:
            self._recorder.__exit__(None, None, None)

    def discard(self) -> None:
        """Let go of the file and leave nothing of it, unless it is sealed."""
        if self._recorder is not None:
            self._recorder.discard()

    def _header(self, subject: Subject, timebase: Timebase) -> SessionHeader:
        facts = self._facts
        return SessionHeader(
            session_id=uuid.uuid4().hex,
            kind="take",
            subject_id=facts.subject_id,
            side=facts.side,
            exercise=facts.exercise,
            source=facts.source,
            software_version=facts.software_version,
            utc_start_ns=timebase.utc_start_ns,
            monotonic_start_ns=timebase.monotonic_start_ns,
            calibration_digest=facts.calibration_digest,
            marker_protocol=self._protocol.name,
            marker_names=self._protocol.names,
            subject_hand=subject_to_json(subject),
            consent_images=facts.consent_images,
            parents=facts.parents,
            station=facts.station,
        )


def no_hand(side: Side, protocol: MarkerProtocol, why: tuple[str, ...] = ()) -> Refused:
    """The refusal of a recording in which no hand was ever understood; the last of the reasons is told."""
    return Refused(
        "hand",
        "never seen open and still" + (f" ({why[-1].rstrip('.')})" if why else ""),
        f"an open {side} hand with {len(protocol.names)} markers for 0.7 s",
        "hold it open and still before the camera, then move",
    )


def event(t_ns: int, cause: str, text: str, severity: str = "caution") -> Event:
    """An event of a recording: what a person should know of it later.

    Args:
        t_ns: When, monotonic.
        cause: Short stable code, such as "outage".
        text: One sentence.
        severity: info, caution or alarm.
    """
    return Event(
        t_ns=t_ns,
        kind="recording",
        severity=severity,
        cause=cause,
        category="",
        subject="",
        value=float("nan"),
        bound=float("nan"),
        text=text,
    )
