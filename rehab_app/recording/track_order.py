"""What ``track`` is asked to do and what it made."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rehab_app.hand.subject import Subject
from rehab_app.recording.tracks import SUFFIX as TRACKS_SUFFIX
from rehab_app.recording.tracks import check_tracks_target
from rehab_app.tracking import Labels
from sessions.errors import Refused
from sessions.records import SIDES, Side
from sessions.store.diskfile import SUFFIX as TAKE_SUFFIX
from sessions.store.diskfile import check_target

OVERLAY_SUFFIXES = (".mp4", ".mkv", ".avi")


@dataclass(frozen=True, slots=True)
class TrackOrder:
    """What to track and how.

    Attributes:
        inputs: The recording, or those of several cameras; the first is the tracking camera's.
        out: File to make: ``.npz`` for arrays, ``.mcap`` for a take; must not exist.
        side: Side of the hand; never inferred.
        software_version: Version of the application.
        protocol: Name or file of the marker protocol; None to recognise it by the labels.
        tracker: Name of the tracker.
        detector: Name of the detector.
        cameras: Calibration file of each input; none where the inputs state their cameras.
        subject: The person's hand, if known already.
        subject_id: Pseudonym of the person, empty if unknown.
        exercise: Name of the movement; empty for the input's name.
        overlay: Video to draw, None for none.
        seed: Of whatever the tracker draws.
        labels: Markers that a person named in the first frame; None to take those of the input, if any.
        colour: JSON of the colour model of the markers; empty for the calibration's or the protocol's.
        parents: Digests of the files that a take is made from.

    Raises:
        Refused: The side is none, or a file cannot be made where it should.
    """

    inputs: tuple[Path, ...]
    out: Path
    side: Side
    software_version: str
    protocol: str | None = None
    tracker: str = "kinematic"
    detector: str = "contrast"
    cameras: tuple[Path, ...] = ()
    subject: Subject | None = None
    subject_id: str = ""
    exercise: str = ""
    overlay: Path | None = None
    seed: int = 0
    labels: Labels | None = None
    colour: str = ""
    parents: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("side", repr(self.side), "left or right", "name the side of the hand")
        if not self.inputs:
            raise Refused("input", "missing", "a recording", "name one")
        if self.makes_take:
            check_target(self.out)
        elif self.out.suffix == TRACKS_SUFFIX:
            check_tracks_target(self.out)
        else:
            raise Refused("--out", repr(self.out.name), "a name ending in .npz or .mcap", "give it one")
        if self.overlay is not None:
            if self.overlay.suffix not in OVERLAY_SUFFIXES:
                bound = "a name ending in " + ", ".join(OVERLAY_SUFFIXES)
                raise Refused("--overlay", repr(self.overlay.name), bound, "give it one")
            check_tracks_target(self.overlay, "--overlay")

    @property
    def makes_take(self) -> bool:
        """Whether a take is made rather than arrays."""
        return self.out.suffix == TAKE_SUFFIX

    @property
    def movement(self) -> str:
        """Name of the movement."""
        return self.exercise or self.inputs[0].stem


@dataclass(frozen=True, slots=True)
class TrackResult:
    """What was made.

    Attributes:
        out: The file.
        sha256: Digest of a take, empty for arrays.
        protocol: Name of the marker protocol.
        tracker: Name of the tracker.
        markers: Number of markers.
        frames: Frames in the file.
        dropped: Frames that the camera lost.
        duration_s: From the first frame to the last.
        measured_share: Share of all markers in all frames that were measured.
        estimated_share: Share that was estimated.
        lost_share: Share that was lost.
        residual_m: rms distance of fitted from seen markers.
        ms_per_frame: Mean time of seeing and tracking per frame.
        complaints: What a person should know, one sentence each.
        overlay: The video that was drawn, None if none was asked for.
    """

    out: Path
    sha256: str
    protocol: str
    tracker: str
    markers: int
    frames: int
    dropped: int
    duration_s: float
    measured_share: float
    estimated_share: float
    lost_share: float
    residual_m: float
    ms_per_frame: float
    complaints: tuple[str, ...]
    overlay: Path | None = None
