"""Values of the clinic's stations, their clocks, and the patients in therapy at them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """A machine that serves the clinic, as it said of itself last.

    Attributes:
        name: Its name.
        holder: Drawn by chance when its process began: two of one name are told apart by it.
        version: Version of its software.
        offset_ns: Its clock minus that of the data base.
        uncertainty_ns: The offset is known to within this much either way.
        seen_utc_ns: When it said so, by the clock of the data base; given by the catalogue.
    """

    name: str
    holder: str
    version: str
    offset_ns: int = 0
    uncertainty_ns: int = 0
    seen_utc_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class PatientClaim:
    """A patient is in therapy at a station.

    Attributes:
        patient: Pseudonym.
        station: Name of the station.
        holder: Which of its processes.
        since_utc_ns: When it began, by the clock of the data base.
        until_utc_ns: Until when it binds unless it is renewed, by the same clock.
    """

    patient: str
    station: str
    holder: str
    since_utc_ns: int
    until_utc_ns: int


@dataclass(frozen=True, slots=True)
class ClockTrip:
    """One question to the data base's clock.

    Attributes:
        asked_utc_ns: Clock of this machine when it was asked.
        there_utc_ns: What the data base's clock said.
        trip_ns: How long the question and its answer took together.
    """

    asked_utc_ns: int
    there_utc_ns: int
    trip_ns: int
