"""Where ``track`` puts what it understands: a take that grows, or arrays that are written at the end."""

from __future__ import annotations

from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.recording.quality import Quality
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.recording.tracks import TrackLog, Tracks, write_tracks
from rehab_app.recording.writing import TakeFacts, TakeWriting
from rehab_app.tracking import TrackedHand
from sessions.records import Event, Status
from sessions.records.fields import Float64, Int64
from sessions.timebase import Timebase


class TrackSink:
    """Takes every capture of a recording; a context manager that leaves nothing unless it is finished.

    Args:
        order: What was asked for.
        protocol: The markers.
        camera: The first camera.
        source: What gave the captures, as the take's header says it.
        calibration_digest: Digest of the camera's calibration; empty for that of its intrinsics.

    Raises:
        Refused: The file cannot be made.
    """

    def __init__(
        self,
        order: TrackOrder,
        protocol: MarkerProtocol,
        camera: Intrinsics,
        source: str,
        calibration_digest: str = "",
    ) -> None:
        self._order = order
        self._protocol = protocol
        self._log = TrackLog(protocol.names, camera)
        self._quality = Quality()
        self._timebase = Timebase(Timebase.now().utc_start_ns, 0)
        self._writing: TakeWriting | None = None
        if order.makes_take:
            facts = TakeFacts(
                path=order.out,
                side=order.side,
                exercise=order.movement,
                software_version=order.software_version,
                source=source,
                calibration_digest=calibration_digest or camera.digest,
                subject_id=order.subject_id,
                parents=order.parents,
            )
            self._writing = TakeWriting(facts, protocol)

    def __enter__(self) -> TrackSink:
        """Nothing is opened before the hand is understood."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove what was not finished; a sealed take stays."""
        if self._writing is not None:
            self._writing.discard()

    @property
    def frames(self) -> int:
        """Captures so far."""
        return len(self._log.t_ns)

    def enough(self, subject: Subject | None) -> bool:
        """Whether there is something to write: a hand, or for arrays markers that were at least followed."""
        if subject is not None:
            return True
        return self._writing is None and self._quality.share(Status.MEASURED) > 0.0

    def saw(self, t_ns: int, rows: Int64) -> None:
        """A capture was handed to the tracker; ``rows`` are its detections' rows in the input, shape (D,)."""
        if not self._log.t_ns:
            self._timebase = Timebase(self._timebase.utc_start_ns, t_ns)
        self._log.saw(t_ns, rows)

    def understood(self, tracked: tuple[TrackedHand, ...], subject: Subject | None) -> None:
        """Captures were understood, in the order of time."""
        self._take(self._log.understood(tracked), subject)

    def note(self, event: Event) -> None:
        """Something happened that a person should know of later."""
        if self._writing is not None:
            self._writing.note(event)

    def finish(
        self, subject: Subject | None, t_s: Float64 | None = None, **more: NDArray[Any]
    ) -> tuple[Tracks, str, Quality]:
        """Write the file.

        Args:
            subject: The person's hand as learnt; without one, only arrays can be written.
            t_s: Time of each capture as the input states it; from the first capture if None.
            more: Further arrays for the ``.npz``.

        Returns:
            The tracks, the digest of a take, and the figures.

        Raises:
            Refused: A take came out shorter than a second.
            OSError: The disk refuses.
        """
        self._take(self._log.end(), subject)
        t_ns = np.array(self._log.t_ns, dtype=np.int64)
        times = 1e-9 * (t_ns - t_ns[0]) if t_s is None else t_s
        tracks = self._log.tracks(times)
        if self._writing is not None:
            return tracks, self._writing.seal().sha256, self._quality
        write_tracks(self._order.out, tracks, **more)
        return tracks, "", self._quality

    def result(
        self,
        finished: tuple[Tracks, str, Quality],
        *,
        dropped: int,
        ms_per_frame: float,
        complaints: tuple[str, ...],
    ) -> TrackResult:
        """What was made, in figures."""
        tracks, sha256, quality = finished
        return TrackResult(
            out=self._order.out,
            sha256=sha256,
            protocol=self._protocol.name,
            tracker=self._order.tracker,
            markers=len(self._protocol.names),
            frames=len(tracks.t_s),
            dropped=dropped,
            duration_s=float(tracks.t_s[-1] - tracks.t_s[0]),
            measured_share=quality.share(Status.MEASURED),
            estimated_share=quality.share(Status.ESTIMATED),
            lost_share=quality.share(Status.LOST),
            residual_m=quality.residual_m,
            ms_per_frame=ms_per_frame,
            complaints=complaints,
            overlay=self._order.overlay,
        )

    def _take(self, tracked: tuple[TrackedHand, ...], subject: Subject | None) -> None:
        for one in tracked:
            self._quality.add(one)
        if self._writing is not None:
            self._writing.take(tracked, subject, self._timebase)
