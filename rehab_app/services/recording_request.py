"""What somebody asks to have recorded, checked before anything starts."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rehab_app.cameras import MOTIONS
from rehab_app.errors import Refused
from rehab_app.hand.protocol import load_protocol
from rehab_app.services.patients import side_named
from rehab_app.tracking import TRACKERS
from sessions.records import Side

VIRTUAL = "virtual"
"""The camera that renders a hand instead of seeing one."""
PROTOCOL = "thesis25"
LIVE_KINDS = ("webcam", "realsense", "kinect", "openni")
"""Kinds of real camera. A page may name these and the virtual one, the command line files as well."""
SHORTEST_S = 1.0
LONGEST_S = 600.0
_PSEUDONYM = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
_LONGEST_NAME = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingRequest:
    """A recording that was asked for.

    Attributes:
        exercise: Name of the movement; of the virtual camera, one of its motions.
        side: Side of the hand.
        seconds: Length, 1 to 600 s.
        camera: Which camera, as ``camera list`` names it.
        beside: Further cameras that look on, calibrated to that one.
        protocol: Marker protocol, by name or TOML file.
        tracker: Name of the tracker.
        person: Pseudonym of whose hand it is, empty if unknown; a hand known of that person is used.
        consent_images: Whether the person consented to images being stored.
        seed: Of the virtual camera and of whatever the tracker draws.
        realtime: Whether frames of the virtual camera come at their time of capture.
        station: JSON of the station that records, and how its clock stands; whoever records fills it in.

    Raises:
        Refused: A value is out of bounds.
    """

    exercise: str
    side: Side
    seconds: float
    camera: str = VIRTUAL
    beside: tuple[str, ...] = ()
    protocol: str = PROTOCOL
    tracker: str = TRACKERS[0]
    person: str = ""
    consent_images: bool = False
    seed: int = 1
    realtime: bool = False
    station: str = ""

    def __post_init__(self) -> None:
        if self.camera == VIRTUAL and self.exercise not in MOTIONS:
            raise Refused(
                "exercise", repr(self.exercise), "one of " + ", ".join(MOTIONS), "choose one of them"
            )
        if not 0 < len(self.exercise) <= _LONGEST_NAME or not self.exercise.isprintable():
            raise Refused(
                "exercise", repr(self.exercise[:20]), f"1 to {_LONGEST_NAME} letters", "name the movement"
            )
        if not SHORTEST_S <= self.seconds <= LONGEST_S:
            bound = f"{SHORTEST_S:g} to {LONGEST_S:g} s"
            raise Refused("take", f"{self.seconds:g} s long", bound, "choose another length")
        if self.tracker not in TRACKERS:
            raise Refused(
                "tracker", repr(self.tracker), "one of " + ", ".join(TRACKERS), "choose one of them"
            )
        if self.person and _PSEUDONYM.fullmatch(self.person) is None:
            bound = "a pseudonym of letters, digits, dots and dashes"
            raise Refused("person", repr(self.person[:20]), bound, "use an id, never a name")
        if len({self.camera, *self.beside}) != 1 + len(self.beside):
            raise Refused("camera", "named twice", "named once", "leave one out")
        side_named(self.side)
        load_protocol(self.protocol)
