"""Verbs of stations: what each says of itself, the data base's clock, who is in therapy where."""

from __future__ import annotations

import time
from collections.abc import Collection

from sqlalchemy import delete, select, text
from sqlalchemy.orm import Session

from sessions.catalogue.ledger import Ledger
from sessions.catalogue.rows import patient_row, value_of
from sessions.catalogue.stations_records import ClockTrip, PatientClaim, Station
from sessions.catalogue.stations_tables import PatientClaimRow, StationRow
from sessions.errors import Refused

FORGOTTEN_NS = 90 * 86_400 * 1_000_000_000
"""A station that said nothing for this long is no longer listed."""
# to the microsecond, which is all that it has; unlike now() it goes on within a transaction
_CLOCK = text("SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint * 1000")


class Stations(Ledger):
    """Stations and claims. Times are those of the data base's clock, which all stations share."""

    def data_base_time_ns(self) -> int:
        """The data base's clock, UTC in ns; that of this machine where it is a file of this machine."""
        with self._reading() as session:
            return self._there_ns(session)

    def clock_trips(self, count: int) -> tuple[ClockTrip, ...]:
        """Ask the data base's clock so many times; nothing where it is this machine's own."""
        if self._engine.dialect.name == "sqlite":
            return ()
        with self._reading() as session:
            self._there_ns(session)  # the first question also opens the connection
            return tuple(self._trip(session) for _ in range(count))

    def say_station(self, station: Station) -> Station | None:
        """Write what a station says of itself; its time is given here.

        Returns:
            What was written under that name before, None at the first time.
        """
        with self._writing() as session:
            now_ns = self._there_ns(session)
            session.execute(delete(StationRow).where(StationRow.seen_utc_ns < now_ns - FORGOTTEN_NS))
            row = session.get(StationRow, station.name)
            before = None if row is None else value_of(Station, row)
            if row is not None:
                session.delete(row)
                session.flush()
            said = (station.holder, station.version, station.offset_ns, station.uncertainty_ns)
            session.add(StationRow(station.name, *said, now_ns))
            return before

    def stations(self) -> tuple[Station, ...]:
        """Every station that said something within 90 days, by name."""
        with self._reading() as session:
            rows = session.scalars(select(StationRow).order_by(StationRow.name))
            return tuple(value_of(Station, row) for row in rows)

    def claim_patient(
        self,
        patient: str,
        station: str,
        holder: str,
        lasts_ns: int,
        gone: Collection[str] = (),
    ) -> tuple[PatientClaim, PatientClaim | None]:
        """Begin or renew a claim: the one transaction in which a patient becomes a station's.

        A holder's own claim goes on since when it began. One of another holder is taken over only once it
        has run out, because that station died or lost the network, or is known to have died.

        Args:
            patient: Pseudonym.
            station: Name of the station.
            holder: Which of its processes.
            lasts_ns: How long the claim binds from now.
            gone: Holders that are known to have died: their claims bind nobody.

        Returns:
            The claim, and the one of another holder that it took over, None where there was none.

        Raises:
            Refused: The patient is unknown, or in therapy at another station.
        """
        with self._writing() as session:
            known, now_ns = patient_row(session, patient).id, self._there_ns(session)
            row = session.get(PatientClaimRow, known)
            if row is None:
                row = PatientClaimRow(known, station, holder, now_ns, now_ns + lasts_ns)
                session.add(row)
                return value_of(PatientClaim, row), None
            before = value_of(PatientClaim, row)
            taken = row.holder != holder
            if taken and row.until_utc_ns > now_ns and row.holder not in gone:
                raise _elsewhere(before)
            if taken:
                row.station, row.holder, row.since_utc_ns = station, holder, now_ns
            row.until_utc_ns = now_ns + lasts_ns
            return value_of(PatientClaim, row), before if taken else None

    def release_patient(self, patient: str, holder: str) -> None:
        """End a holder's claim; that of another holder stays."""
        mine = PatientClaimRow.patient == patient, PatientClaimRow.holder == holder
        with self._writing() as session:
            session.execute(delete(PatientClaimRow).where(*mine))

    def claims(self) -> tuple[PatientClaim, ...]:
        """Claims that bind now, by patient."""
        with self._reading() as session:
            binding = PatientClaimRow.until_utc_ns > self._there_ns(session)
            rows = session.scalars(select(PatientClaimRow).where(binding).order_by(PatientClaimRow.patient))
            return tuple(value_of(PatientClaim, row) for row in rows)

    def _trip(self, session: Session) -> ClockTrip:
        asked_ns, began_ns = time.time_ns(), time.monotonic_ns()
        there_ns = self._there_ns(session)
        return ClockTrip(asked_ns, there_ns, time.monotonic_ns() - began_ns)

    def _there_ns(self, session: Session) -> int:
        if self._engine.dialect.name == "sqlite":
            return self._clock_ns()
        return int(session.execute(_CLOCK).scalar_one())


def _elsewhere(claim: PatientClaim) -> Refused:
    """The sentence about a patient who is in therapy elsewhere."""
    began = time.strftime("%H:%M:%S", time.localtime(claim.since_utc_ns // 1_000_000_000))
    return Refused(
        f"patient {claim.patient}",
        f"in therapy at station {claim.station} since {began}",
        "in therapy at one station only",
        "end it there; a station that died sets its patient free within a minute",
    )
