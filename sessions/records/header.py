"""Who, what, when and under which limits: the first thing in every session file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sessions.errors import Refused
from sessions.records.names import SIDES, Side

FORMAT_VERSION = 1
Kind = Literal["take", "therapy"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionHeader:
    """Metadata ``session`` of a file. Strings that hold JSON belong to the package that wrote them.

    Attributes:
        session_id: 32 hexadecimal digits, unique.
        kind: "take" (a recorded demonstration) or "therapy" (a run on the robot).
        subject_id: Pseudonym of the person whose hand this is; never a name.
        side: Side of that hand, stored and never inferred.
        exercise: Name of the exercise or movement.
        source: Where the motion came from, such as "virtual-camera" or "qualisys-tsv".
        software_version: Version of the application that wrote the file.
        calibration_digest: SHA-256 of the camera calibration, empty where no camera took part.
        marker_protocol: Name of the marker protocol, empty where none.
        marker_names: Row names of every MarkerFrame.
        robot_joints: Column names of the robot blocks.
        subject_hand: JSON of the subject's hand geometry (robot_iface.kinematics.HandGeometry).
        limits: JSON of the limits that held.
        prescription: JSON of the prescription that was played.
        certificate: JSON of the rehearsal certificate.
        consent_images: Whether images may be stored.
        parents: SHA-256 digests of the files this one was made from.
        utc_start_ns: UTC at the session's start.
        monotonic_start_ns: Monotonic clock at the same instant.
        station: JSON of the station that recorded it and how its clock stood to the data base's; empty where
            nobody said.
        format_version: Version of the file format.

    Raises:
        Refused: The side, kind or format version is not one of those that exist.
    """

    session_id: str
    kind: Kind
    subject_id: str
    side: Side
    exercise: str
    source: str
    software_version: str
    utc_start_ns: int
    monotonic_start_ns: int
    calibration_digest: str = ""
    marker_protocol: str = ""
    marker_names: tuple[str, ...] = ()
    robot_joints: tuple[str, ...] = ()
    subject_hand: str = ""
    limits: str = ""
    prescription: str = ""
    certificate: str = ""
    consent_images: bool = False
    parents: tuple[str, ...] = ()
    station: str = ""
    format_version: int = FORMAT_VERSION

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("side", repr(self.side), "left or right", "name the side of the hand")
        if self.kind not in ("take", "therapy"):
            raise Refused("session kind", repr(self.kind), "take or therapy", "name the kind")
        if not 1 <= self.format_version <= FORMAT_VERSION:
            raise Refused(
                "format version",
                str(self.format_version),
                f"at most {FORMAT_VERSION}",
                "open the file with a newer rehab-app",
            )
