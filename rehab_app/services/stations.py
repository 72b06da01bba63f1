"""Stations of a clinic: each says what it is and how its clock stands; who is in therapy where."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.station_claims import Claims
from rehab_app.services.station_clock import TRIPS, ClockOffset, clock_warning, offset_of
from sessions.catalogue import Catalogue, PatientClaim, Station

SAY_S = 30.0
SILENT_S = 90.0
"""A station that missed three of its turns is silent."""
_LAST_WAIT_S = 2.0


@dataclass(frozen=True, slots=True)
class StationState:
    """A station as the clinic knows it.

    Attributes:
        station: What it said of itself last.
        here: Whether it is this one.
        silent_s: How long ago it said so, by the clock of the data base, in s.
        clock: How its clock stands.
        warning: A sentence where its clock is off by more than 2 s, else "".
        patients: Who is in therapy there now.
    """

    station: Station
    here: bool
    silent_s: float
    clock: ClockOffset
    warning: str
    patients: tuple[PatientClaim, ...]

    @property
    def silent(self) -> bool:
        """Whether it is off, or out of reach."""
        return self.silent_s > SILENT_S


class Stations:
    """This station among the others.

    Args:
        catalogue: The clinic's catalogue.
        claims: The claims of this process.

    Attributes:
        trouble: Why this station could not say itself, or that another has its name; "" where all is well.
        clock: How this station's clock stood last, None where it was never measured.
    """

    def __init__(self, catalogue: Catalogue, claims: Claims) -> None:
        self._catalogue = catalogue
        self._claims = claims
        self._said = False
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._work, name="station", daemon=True)
        self.trouble = ""
        self.clock: ClockOffset | None = None

    @property
    def name(self) -> str:
        """Name of this station."""
        return self._claims.identity.name

    def start(self) -> None:
        """Say now and every 30 s what this station is, on a thread of its own."""
        self._thread.start()

    def close(self) -> None:
        """End."""
        self._end.set()
        if self._thread.is_alive():
            self._thread.join(_LAST_WAIT_S)

    def measure(self) -> ClockOffset:
        """Measure how this station's clock stands to the data base's.

        Raises:
            Refused: The data base does not answer.
        """
        self.clock = offset_of(self._catalogue.clock_trips(TRIPS))
        return self.clock

    def say(self) -> None:
        """Measure the clock and write what this station is.

        Raises:
            Refused: The data base does not answer.
        """
        me, clock = self._claims.identity, self.measure()
        said = Station(
            name=me.name,
            holder=me.holder,
            version=me.version,
            offset_ns=clock.offset_ns,
            uncertainty_ns=clock.uncertainty_ns,
        )
        before = self._catalogue.say_station(said)
        # at the first time it may be this machine's own before a restart; later it is another machine
        doubled = self._said and before is not None and before.holder != me.holder
        self._said = True
        other = f"Another machine calls itself station {me.name}, too: give each its own name (station)."
        self.trouble = other if doubled else clock_warning(me.name, clock)

    def stamp(self) -> str:
        """JSON for the header of a session: which station, and how its clock stood; null where unknown."""
        clock = self.clock
        if clock is None and not self._thread.is_alive():  # a server measures on its own thread
            try:
                clock = self.measure()
            except Refused:
                clock = None
        return msgspec.json.encode(
            {
                "name": self.name,
                "clock_offset_ns": None if clock is None else clock.offset_ns,
                "clock_uncertainty_ns": None if clock is None else clock.uncertainty_ns,
            }
        ).decode()

    def list(self, actor: Account) -> tuple[StationState, ...]:
        """Every station that said something within 90 days, by name.

        Raises:
            Refused: The actor may not view, or the data base does not answer.
        """
        require(actor, "view")
        now_ns, claims = self._catalogue.data_base_time_ns(), self._catalogue.claims()
        return tuple(self._state(one, now_ns, claims) for one in self._catalogue.stations())

    def _state(self, station: Station, now_ns: int, claims: tuple[PatientClaim, ...]) -> StationState:
        clock = ClockOffset(station.offset_ns, station.uncertainty_ns)
        return StationState(
            station=station,
            here=station.name == self.name,
            silent_s=max(0.0, (now_ns - station.seen_utc_ns) / 1e9),
            clock=clock,
            warning=clock_warning(station.name, clock),
            patients=tuple(claim for claim in claims if claim.station == station.name),
        )

    def _work(self) -> None:
        while True:
            try:
                self.say()
            except Refused as refusal:
                self.trouble = str(refusal)
            if self._end.wait(SAY_S):
                return
