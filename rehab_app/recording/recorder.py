"""Records a take from a camera: every capture goes through the pipeline into the file as it comes.

The file begins once the hand is learnt (its header states the hand), with the captures since the first one.
Images are shown, never stored. Whatever interrupts the recording leaves a recoverable partial file.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rehab_app.cameras import Camera, Frame
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject, subject_to_json
from rehab_app.recording.pipeline import LivePose, Pipeline
from rehab_app.recording.take import SHORTEST_S, TakeRecorder
from rehab_app.tracking import KinematicTracker, TrackedHand
from rehab_app.vision import MarkerDetector
from sessions.errors import Refused
from sessions.records import SIDES, SessionHeader, Side, Status
from sessions.records.fields import UInt8
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

    Raises:
        Refused: The side or the length is out of bounds.
    """

    path: Path
    side: Side
    exercise: str
    seconds: float
    software_version: str
    subject_id: str = ""

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
        residual_m: rms distance of fitted from seen markers.
        subject: The person's hand as learnt.
    """

    path: Path
    sha256: str
    frames: int
    dropped: int
    duration_s: float
    landmarks: int
    gaps: int
    measured_share: float
    residual_m: float
    subject: Subject


def record_take(
    camera: Camera,
    protocol: MarkerProtocol,
    order: TakeOrder,
    *,
    on_frame: Callable[[LivePose], None] | None = None,
    finished: Callable[[], bool] | None = None,
    timebase: Timebase | None = None,
) -> RecordedTake:
    """Record one take with the kinematic tracker, as fast as the camera gives frames.

    Args:
        camera: Not yet open; it is opened and closed here.
        protocol: Markers that the hand wears.
        order: What to record.
        on_frame: Told of every capture, on this thread.
        finished: Asked at every capture whether to end early.
        timebase: Pairing of the camera's clock with UTC; by default read at the first capture.

    Raises:
        Refused: The path cannot be written to, no open hand was seen, or the take came out shorter than 1 s;
            no file is left then.
    """
    check_target(order.path)
    pipeline = Pipeline(MarkerDetector(), KinematicTracker(protocol, order.side))
    writing = _Writing(order, protocol, camera, timebase)
    end = _End(order.seconds, finished)
    with camera:
        try:
            for seen in pipeline.run(camera, end):
                writing.take(seen.tracked, pipeline.tracker.subject, seen.frame)
                if on_frame is not None:
                    on_frame(seen.live)
            return writing.seal(pipeline.tracker.subject)
        finally:
            writing.close()


class _End:
    """Says when a recording is over: after its length, or when it is asked to end."""

    def __init__(self, seconds: float, finished: Callable[[], bool] | None) -> None:
        self._length_ns = round(1e9 * seconds)
        self._finished = finished
        self._first_ns: int | None = None

    def __call__(self, frame: Frame) -> bool:
        if self._first_ns is None:
            self._first_ns = frame.t_capture_ns
        beyond = frame.t_capture_ns - self._first_ns > self._length_ns
        return beyond or (self._finished is not None and self._finished())


class _Writing:
    """The file that grows, and the figures of what is in it."""

    def __init__(
        self, order: TakeOrder, protocol: MarkerProtocol, camera: Camera, timebase: Timebase | None
    ) -> None:
        self._order = order
        self._protocol = protocol
        self._camera = camera
        self._timebase = timebase
        self._recorder: TakeRecorder | None = None
        self._dropped = 0
        self._statuses: list[UInt8] = []
        self._squares_m2: list[float] = []

    def take(self, tracked: tuple[TrackedHand, ...], subject: Subject | None, frame: Frame) -> None:
        """Append what was understood; the file is opened by the first of it."""
        self._timebase = self._timebase or _paired(frame.t_capture_ns)
        self._dropped += frame.dropped
        if not tracked or subject is None:
            return
        if self._recorder is None:
            self._recorder = TakeRecorder(self._order.path, self._header(subject, self._timebase))
        for one in tracked:
            self._recorder.add(one.markers, one.pose)
            self._statuses.append(one.markers.status)
            self._squares_m2.append(one.pose.residual_m**2)

    def seal(self, subject: Subject | None) -> RecordedTake:
        """Finish the file."""
        if self._recorder is None or subject is None:
            raise Refused(
                "hand",
                "never seen open and still",
                f"an open {self._order.side} hand with {len(self._protocol.names)} markers for 0.7 s",
                "hold it open and still before the camera, then move",
            )
        duration_s = self._recorder.duration_s
        sealed = self._recorder.seal()
        measured = np.array(self._statuses) == Status.MEASURED
        starts = ~measured & np.pad(measured[:-1], ((1, 0), (0, 0)), constant_values=True)
        return RecordedTake(
            path=sealed.path,
            sha256=sealed.sha256,
            frames=len(measured),
            dropped=self._dropped,
            duration_s=duration_s,
            landmarks=measured.shape[1],
            gaps=int(starts.sum()),
            measured_share=float(measured.mean()),
            residual_m=float(np.sqrt(np.nanmean(self._squares_m2))),
            subject=subject,
        )

    def close(self) -> None:
        """Let go of the file; what is not sealed stays as a partial."""
        if self._recorder is not None:
            self._recorder.__exit__(None, None, None)

    def _header(self, subject: Subject, timebase: Timebase) -> SessionHeader:
        return SessionHeader(
            session_id=uuid.uuid4().hex,
            kind="take",
            subject_id=self._order.subject_id,
            side=self._order.side,
            exercise=self._order.exercise,
            source=self._camera.name,
            software_version=self._order.software_version,
            utc_start_ns=timebase.utc_start_ns,
            monotonic_start_ns=timebase.monotonic_start_ns,
            calibration_digest=self._camera.intrinsics.digest,
            marker_protocol=self._protocol.name,
            marker_names=self._protocol.names,
            subject_hand=subject_to_json(subject),
        )


def _paired(t_capture_ns: int) -> Timebase:
    """The clocks now; a camera in simulated time is taken to have made its first capture now."""
    now = Timebase.now()
    same_clock = abs(time.monotonic_ns() - t_capture_ns) < _SAME_CLOCK_NS
    return now if same_clock else Timebase(now.utc_start_ns, t_capture_ns)
