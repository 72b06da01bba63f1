"""Records a take from a camera: every capture goes through the pipeline into the file as it comes.

The file begins once the hand is learnt (its header states the hand), with the captures since the first one.
It is written on a thread of its own: neither the disk nor an image's compression holds up the next capture.
Images are stored only with consent. Whatever interrupts the recording leaves a recoverable partial file.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from rehab_app.cameras import Camera, Frame, Outage
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.recording.behind import Behind
from rehab_app.recording.live_pose import LivePose
from rehab_app.recording.noted import Noted
from rehab_app.recording.pipeline import Pipeline, Seen
from rehab_app.recording.take import SHORTEST_S
from rehab_app.recording.writing import TakeFacts, TakeWriting, no_hand
from rehab_app.tracking import TrackedHand, Tracker, make_tracker
from rehab_app.vision import Detector, make_detector
from sessions.errors import Refused
from sessions.records import SIDES, Side, Status
from sessions.store.diskfile import check_target
from sessions.timebase import Timebase

LONGEST_S = 3600.0
_SAME_CLOCK_NS = 10_000_000_000


@dataclass(frozen=True, slots=True)
class TakeOrder:
    """What to record, and what the header says of it.

    Attributes:
        path: The take file; must not exist.
        side: Side of the hand; never inferred.
        exercise: Name of the movement.
        seconds: Length, 1 to 3600 s, from the first capture.
        software_version: Version of the application.
        subject_id: Pseudonym of the person, empty if unknown.
        consent_images: Whether the person consented to images being stored: they are, then.
        calibration_digest: Digest of the camera's calibration; empty for that of its intrinsics alone.
        station: JSON of the station that records, and how its clock stands; may be empty.

    Raises:
        Refused: The side or the length is out of bounds.
    """

    path: Path
    side: Side
    exercise: str
    seconds: float
    software_version: str
    subject_id: str = ""
    consent_images: bool = False
    calibration_digest: str = ""
    station: str = ""

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("side", repr(self.side), "left or right", "name the side of the hand")
        if not SHORTEST_S <= self.seconds <= LONGEST_S:
            bound = f"{SHORTEST_S:g} to {LONGEST_S:g} s"
            raise Refused("take", f"{self.seconds:g} s long", bound, "choose another length")


@dataclass(frozen=True, slots=True)
class RecordedTake:
    """A take that was recorded and sealed.

    Attributes:
        path: The file.
        sha256: Its digest.
        frames: Captures in it.
        dropped: Captures that the camera lost.
        duration_s: From its first to its last capture.
        landmarks: Markers per capture.
        gaps: Unbroken spans in which a marker was not measured, over all markers.
        measured_share: Share of all markers in all captures that were measured.
        estimated_share: Share that was estimated.
        lost_share: Share that was lost.
        residual_m: rms distance of fitted from seen markers.
        subject: The person's hand as learnt.
        complaints: What went wrong meanwhile, one sentence each.
    """

    path: Path
    sha256: str
    frames: int
    dropped: int
    duration_s: float
    landmarks: int
    gaps: int
    measured_share: float
    estimated_share: float
    lost_share: float
    residual_m: float
    subject: Subject
    complaints: tuple[str, ...]


def record_take(
    cameras: Camera | Sequence[Camera],
    protocol: MarkerProtocol,
    order: TakeOrder,
    *,
    tracker: Tracker | None = None,
    detector: Detector | None = None,
    views: Sequence[View] = (PRIMARY,),
    on_frame: Callable[[LivePose], None] | None = None,
    on_outage: Callable[[Outage], None] | None = None,
    finished: Callable[[], bool] | None = None,
    timebase: Timebase | None = None,
) -> RecordedTake:
    """Record one take, as fast as the camera gives frames.

    Args:
        cameras: One or several, not yet open; they are opened and closed here.
        protocol: Markers that the hand wears.
        order: What to record.
        tracker: Names the markers; the kinematic one by default.
        detector: Finds them; the default one by default.
        views: Where each camera stands.
        on_frame: Told of every capture, on this thread; it must not take long.
        on_outage: Told while a camera gives nothing, about twice a second.
        finished: Asked at every capture whether to end early.
        timebase: Pairing of the camera's clock with UTC; by default read at the first capture.

    Raises:
        Refused: The path cannot be written to, no open hand was seen, or the take came out shorter than 1 s;
            no file is left then.
    """
    check_target(order.path)
    several = (cameras,) if not isinstance(cameras, Sequence) else tuple(cameras)
    naming = tracker or make_tracker("kinematic", protocol, order.side)
    pipeline = Pipeline(detector or make_detector(), naming, views)
    end = _End(order.seconds, finished)
    with ExitStack() as opened:
        for camera in several:
            opened.enter_context(camera)
        recording = _Recording(order, protocol, several[0], timebase)
        try:
            for seen in pipeline.run(several, end):
                if isinstance(seen, Outage):
                    recording.outage(seen)
                    if on_outage is not None:
                        on_outage(seen)
                    if end.over(seen.t_ns):
                        break
                    continue
                recording.take(seen, naming.subject)
                if on_frame is not None:
                    on_frame(seen.live)
            recording.rest(naming.finish(), naming.subject)
            return recording.seal(naming.subject)
        finally:
            recording.close()


class _End:
    """Says when a recording is over: after its length, or when it is asked to end."""

    def __init__(self, seconds: float, finished: Callable[[], bool] | None) -> None:
        self._length_ns = round(1e9 * seconds)
        self._finished = finished
        self._first_ns: int | None = None

    def over(self, t_ns: int) -> bool:
        """Whether it is over at a time; before the first capture, only if it is asked to end."""
        if self._finished is not None and self._finished():
            return True
        return self._first_ns is not None and t_ns - self._first_ns > self._length_ns

    def __call__(self, frame: Frame) -> bool:
        if self._first_ns is None:
            self._first_ns = frame.t_capture_ns
        return self.over(frame.t_capture_ns)


class _Recording:
    """The file that grows behind the pipeline."""

    def __init__(
        self, order: TakeOrder, protocol: MarkerProtocol, camera: Camera, timebase: Timebase | None
    ) -> None:
        self._order = order
        self._protocol = protocol
        self._timebase = timebase
        facts = TakeFacts(
            path=order.path,
            side=order.side,
            exercise=order.exercise,
            software_version=order.software_version,
            source=camera.name,
            calibration_digest=order.calibration_digest or camera.intrinsics.digest,
            subject_id=order.subject_id,
            consent_images=order.consent_images,
            station=order.station,
        )
        self._writing = TakeWriting(facts, protocol)
        self._behind = Behind()
        self._noted = Noted()
        self._dropped = 0

    def take(self, seen: Seen, subject: Subject | None) -> None:
        """Queue what was understood, and the images where they may be stored."""
        frame, timebase = seen.frame, self._timebase or _paired(seen.frame.t_capture_ns)
        self._timebase = timebase
        self._dropped += seen.instant.dropped
        events = self._noted.of(seen)
        images = frame if self._order.consent_images else None

        def write() -> None:
            self._writing.take(seen.tracked, subject, timebase)
            for event in events:
                self._writing.note(event)
            if images is not None:
                self._writing.picture(images)

        self._behind.do(write)

    def rest(self, tracked: tuple[TrackedHand, ...], subject: Subject | None) -> None:
        """Queue what the tracker held back until the end."""
        if (timebase := self._timebase) is not None:
            self._behind.do(lambda: self._writing.take(tracked, subject, timebase))

    def outage(self, outage: Outage) -> None:
        """Queue the note that there are no captures."""
        for event in self._noted.of_outage(outage):
            self._behind.do(lambda noted=event: self._writing.note(noted))

    def seal(self, subject: Subject | None) -> RecordedTake:
        """Finish the file."""
        self._behind.finish()
        if subject is None:
            self._writing.discard()
            raise no_hand(self._order.side, self._protocol, self._noted.sentences)
        written = self._writing.seal()
        quality = written.quality
        return RecordedTake(
            path=written.path,
            sha256=written.sha256,
            frames=quality.frames,
            dropped=self._dropped,
            duration_s=written.duration_s,
            landmarks=len(self._protocol.names),
            gaps=quality.gaps,
            measured_share=quality.share(Status.MEASURED),
            estimated_share=quality.share(Status.ESTIMATED),
            lost_share=quality.share(Status.LOST),
            residual_m=quality.residual_m,
            subject=subject,
            complaints=self._noted.sentences,
        )

    def close(self) -> None:
        """Write what waits, then let go of the file; what is not sealed stays as a partial."""
        try:
            self._behind.finish()
        finally:
            self._behind.close()
            self._writing.close()


def _paired(t_capture_ns: int) -> Timebase:
    """The clocks now; a camera in simulated time is taken to have made its first capture now."""
    now = Timebase.now()
    same_clock = abs(time.monotonic_ns() - t_capture_ns) < _SAME_CLOCK_NS
    return now if same_clock else Timebase(now.utc_start_ns, t_capture_ns)
