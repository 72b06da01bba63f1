"""From a file of another program to a take: read, choose the protocol, scale the hand, fit it, write."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rehab_app.hand.calibration import calibrate_subject
from rehab_app.hand.pose_fit import HandFit, PoseFitter
from rehab_app.hand.protocol import PROTOCOLS, MarkerProtocol, load_protocol
from rehab_app.hand.records import take_records
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject, subject_to_json
from rehab_app.recording.importers.c3d import read_c3d
from rehab_app.recording.importers.glove import glove_hand, read_glove
from rehab_app.recording.importers.leap import SUFFIXES as LEAP
from rehab_app.recording.importers.leap import read_leap
from rehab_app.recording.importers.mediapipe import read_mediapipe
from rehab_app.recording.importers.qualisys import read_qualisys
from rehab_app.recording.importers.recorded_file import RecordedFile, check_readable
from rehab_app.recording.take import SHORTEST_S, too_short, write_take
from sessions.errors import Refused
from sessions.records import SIDES, Side
from sessions.records.header import SessionHeader
from sessions.store import SealedSession
from sessions.timebase import Timebase

READERS: dict[str, Callable[[Path], RecordedFile]] = {
    ".tsv": read_qualisys,
    ".npz": read_mediapipe,
    ".c3d": read_c3d,
}
"""Reader of each kind of file with markers, by its suffix."""
GLOVE = ".csv"
"""Suffix of a glove's recording, which has joint angles and no markers."""

_SHARE_NAMED = 0.5  # share of a protocol's markers that a recording must name to be recognised


@dataclass(frozen=True, slots=True)
class ImportedTake:
    """A recording understood: the person's hand and its pose in every frame.

    Attributes:
        source: Kind of file, such as "qualisys-tsv".
        protocol: The markers, None of a glove.
        side: Side of the hand, as stated.
        series: The markers over time, gaps as NaN.
        subject: The hand scaled to the person.
        fit: The hand in every frame, gaps as NaN and LOST.
        utc_start_ns: When it was recorded; when it was imported if the file does not say.
        shortest_s: What it must last at least, s.
    """

    source: str
    protocol: MarkerProtocol | None
    side: Side
    series: LandmarkSeries
    subject: Subject
    fit: HandFit
    utc_start_ns: int
    shortest_s: float = SHORTEST_S

    @property
    def landmarks(self) -> int:
        """Markers per frame."""
        return len(self.series.names)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.series.t_s.size

    @property
    def gaps(self) -> int:
        """Unbroken spans in which a marker is missing, over all markers."""
        return self.series.gap_spans()

    @property
    def duration_s(self) -> float:
        """Time from the first to the last frame, s."""
        return self.series.duration_s

    @property
    def residual_m(self) -> float:
        """Distance of fitted from seen markers, rms over all frames, m; NaN without markers."""
        if self.protocol is None:
            return float("nan")
        return float(np.sqrt(np.nanmean(self.fit.residual_m**2)))

    def write(
        self, path: Path, *, exercise: str, software_version: str, subject_id: str = ""
    ) -> SealedSession:
        """Write the take.

        Args:
            path: Final name, ending in ``.mcap``; must not exist.
            exercise: Name of the movement.
            software_version: Version of the application.
            subject_id: Pseudonym of the person, empty if unknown.

        Raises:
            Refused: The path cannot be written to; nothing is left there.
        """
        header = SessionHeader(
            session_id=uuid.uuid4().hex,
            kind="take",
            subject_id=subject_id,
            side=self.side,
            exercise=exercise,
            source=self.source,
            software_version=software_version,
            utc_start_ns=self.utc_start_ns,
            monotonic_start_ns=0,
            marker_protocol="" if self.protocol is None else self.protocol.name,
            marker_names=self.series.names,
            subject_hand=subject_to_json(self.subject),
        )
        t_ns = np.round(1e9 * (self.series.t_s - self.series.t_s[0])).astype(np.int64)
        return write_take(path, header, take_records(t_ns, self.series, self.fit), self.shortest_s)


def import_recording(path: Path, side: str, protocol: str | Path | None = None) -> ImportedTake:
    """Read a recording of another program and fit the person's hand to it.

    Args:
        path: A ``.tsv`` of Qualisys, an ``.npz`` of MediaPipe landmarks, a ``.c3d``, a glove's ``.csv``, or a
            ``.json.lz`` or ``.json`` of a Leap Motion.
        side: "left" or "right"; stated, never inferred. Empty: the side that a Leap Motion's file states,
            right for a file that states none.
        protocol: Name or file of the marker protocol; left out, the built-in one whose markers are named.

    Raises:
        Refused: The file, side or protocol is unusable: one sentence says why and what to do.
    """
    if path.suffix.lower() == GLOVE:
        return _worn(path, _side(side or "right"), protocol)
    recorded, sided = _read(path, side)
    if recorded.series.duration_s < recorded.shortest_s:
        raise too_short(recorded.series.duration_s, recorded.shortest_s)
    markers = _recognised(path, recorded, protocol)
    series = _chosen(path, recorded.series, markers)
    subject = calibrate_subject(series, markers, sided)
    fit = PoseFitter(subject, markers).fit(series.p_camera_m)
    utc_ns = Timebase.now().utc_start_ns if recorded.utc_start_ns is None else recorded.utc_start_ns
    return ImportedTake(recorded.source, markers, sided, series, subject, fit, utc_ns, recorded.shortest_s)


def _read(path: Path, side: str) -> tuple[RecordedFile, Side]:
    """The markers of a recording and the side of their hand."""
    suffix = path.suffix.lower()
    asked = _side(side or "right")
    if suffix not in (*READERS, *LEAP):
        known = ", ".join((*READERS, GLOVE, *LEAP))
        raise Refused("recording", repr(path.name), f"one of {known}", "convert it to one of these")
    check_readable(path)
    if suffix in LEAP:
        return read_leap(path, asked if side else None)
    return READERS[suffix](path), asked


def _worn(path: Path, side: Side, protocol: str | Path | None) -> ImportedTake:
    """A glove's recording: no markers to choose or to fit."""
    if protocol is not None:
        raise Refused("--protocol", f"given for {path.name}", "left out", "a glove has no markers")
    check_readable(path)
    series, subject, fit = glove_hand(read_glove(path), side)
    if series.duration_s < SHORTEST_S:
        raise too_short(series.duration_s)
    return ImportedTake("glove-csv", None, side, series, subject, fit, Timebase.now().utc_start_ns)


def _side(side: str) -> Side:
    for known in SIDES:
        if side == known:
            return known
    raise Refused("side", repr(side), "left or right", "name the side of the hand")


def _recognised(path: Path, recorded: RecordedFile, protocol: str | Path | None) -> MarkerProtocol:
    if protocol is not None:
        return load_protocol(protocol)
    named = set(recorded.series.names)
    known = [load_protocol(name) for name in PROTOCOLS]
    best = max(known, key=lambda protocol: 2 * len(named & set(protocol.names)) - len(protocol.names))
    if len(named & set(best.names)) < _SHARE_NAMED * len(best.names):
        some = ", ".join(recorded.series.names[:5])
        raise Refused(
            f"recording {path.name}",
            f"without hand markers (it names {some})",
            "labelled by a protocol: " + ", ".join(PROTOCOLS),
            "rename the markers or give a protocol file",
        )
    return best


def _chosen(path: Path, series: LandmarkSeries, protocol: MarkerProtocol) -> LandmarkSeries:
    """The protocol's markers of a recording, in its order; every one must be seen at some time."""
    for name in protocol.names:
        if name not in series.names:
            raise Refused(
                f"recording {path.name}",
                f"without marker {name}",
                f"labelled by protocol {protocol.name}",
                "label it, or give a protocol without it",
            )
    rows = [series.names.index(name) for name in protocol.names]
    chosen = LandmarkSeries(series.t_s, protocol.names, series.p_camera_m[:, rows])
    for name, seen in zip(protocol.names, np.atleast_1d(chosen.seen.any(axis=0)), strict=True):
        if not seen:
            raise Refused(
                f"recording {path.name}, marker {name}",
                "never seen",
                "seen at some time",
                "label it, or give a protocol without it",
            )
    return chosen
