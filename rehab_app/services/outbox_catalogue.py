"""The catalogue of a station: on a server that may go away, while recordings and therapy here go on."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar, cast

from rehab_app.errors import NoAnswer
from rehab_app.services.outbox_delivery import LATER_ENTRIES
from rehab_app.services.outbox_folder import OutboxFolder, Waiting
from rehab_app.services.outbox_memory import RememberingCatalogue
from sessions.catalogue import (
    AssistanceMemory,
    AuditRow,
    Catalogue,
    DayLimits,
    FitCheck,
    Hand,
    PatientEntry,
    PrescriptionRow,
    Take,
    TherapySession,
)
from sessions.catalogue.rows import SHORTEST_ID

V = TypeVar("V")
_NUMBER_BYTES = 16
_HOLDS_AT_ONCE = (DayLimits, AssistanceMemory, FitCheck, Hand)


def open_catalogue(folder: Path, url: str) -> Catalogue:
    """The catalogue of a clinic: a file in its folder as it is, one on a server with an outbox before it.

    Args:
        folder: The clinic folder.
        url: Address of the catalogue, "" for the file.

    Raises:
        Refused: The folder or data base cannot be used.
    """
    if not url.startswith("postgresql"):
        return Catalogue.open(folder, url)
    opened = StationCatalogue.open(folder, url)
    if isinstance(opened, StationCatalogue):
        opened.outbox = OutboxFolder(folder)
    return opened


class StationCatalogue(RememberingCatalogue):
    """What ends a recording or a session is kept for later where the server does not answer.

    Each such row is a delivery with a number, already at the first try: a connection that breaks while it is
    committed leaves it open whether the row was written, and the outbox then brings it under the same number.
    While anything waits, whatever comes next waits behind it, so that the order is kept.

    Attributes:
        outbox: What waits.
        woken: Called when something was put there.
    """

    outbox: OutboxFolder
    woken: Callable[[], None] = staticmethod(lambda: None)

    def plain(self) -> Catalogue:
        """The same catalogue, which remembers nothing and puts nothing off."""
        return Catalogue(self._engine, self._clock)

    def add_take(self, take: Take) -> Take:
        """Add a take, now or later."""
        row = replace(take, parent=self._whole(take.parent))
        here = replace(take, id=take.sha256[:SHORTEST_ID], created_utc_ns=self._clock_ns())
        return self._kept("take", row, super().add_take, here)

    def add_session(self, therapy: TherapySession) -> TherapySession:
        """Add a session, now or later."""
        row = replace(therapy, take=self._whole(therapy.take))
        here = replace(therapy, id=therapy.sha256[:SHORTEST_ID])
        return self._kept("session", row, super().add_session, here)

    def add_prescription(self, prescription: PrescriptionRow) -> PrescriptionRow:
        """Add what was ordered, now or later."""
        row = replace(prescription, take=self._whole(prescription.take))
        return self._kept("prescription", row, super().add_prescription, prescription)

    def add_assistance(self, memory: AssistanceMemory) -> AssistanceMemory:
        """Remember assistance, now or later."""
        row = replace(memory, session=self._whole(memory.session))
        return self._kept("assistance", row, super().add_assistance, memory)

    def add_fit_check(self, check: FitCheck) -> FitCheck:
        """Keep a fit check, now or later."""
        row = replace(check, session=self._whole(check.session))
        return self._kept("fit-check", row, super().add_fit_check, check)

    def add_day_limits(self, limits: DayLimits) -> DayLimits:
        """Keep measured limits, now or later."""
        return self._kept("limits", limits, super().add_day_limits, limits)

    def add_hand(self, hand: Hand) -> Hand:
        """Keep a hand, now or later."""
        return self._kept("hand", hand, super().add_hand, hand)

    def add_entry(self, entry: PatientEntry) -> PatientEntry:
        """Write an entry: of what is written during a session now or later, of anything else only now."""
        if entry.kind not in LATER_ENTRIES:
            return super().add_entry(entry)
        row = replace(entry, session=self._whole(entry.session))
        here = replace(entry, created_utc_ns=self._clock_ns())
        return self._kept("entry", row, super().add_entry, here)

    def end_sign_ins(self, user: str, digest: str = "") -> None:
        """End sign-ins, now or later."""
        end = super().end_sign_ins
        self._kept_content("sign-out", {"user": user, "digest": digest}, lambda: end(user, digest), None)

    def record_audit_rows(self, rows: Iterable[tuple[str, str, str, str]]) -> tuple[AuditRow, ...]:
        """Append to the audit, now or later; rows that wait have no number and no hash yet."""
        given, now_ns, record = tuple(rows), self._clock_ns(), super().record_audit_rows
        here = tuple(_unchained(now_ns, *row) for row in given)
        return self._kept_content("audit", {"rows": given}, lambda: record(given), here)

    def _kept(self, kind: str, row: V, write: Callable[[V], V], here: V) -> V:
        return self._kept_content(kind, asdict(cast("Any", row)), lambda: write(row), here)

    def _kept_content(self, kind: str, content: dict[str, Any], write: Callable[[], V], here: V) -> V:
        """Write now, or keep for later and give what stands in for the row till then.

        Raises:
            Refused: The catalogue answers, and cannot take the row.
        """
        waiting = Waiting(secrets.token_hex(_NUMBER_BYTES), kind, self._clock_ns(), content)
        if not self.outbox.names():
            try:
                with self.once(waiting.id):
                    return write()
            except NoAnswer:
                pass
        with self._remembering:
            self.outbox.add(waiting)
            self._stand_in(here)
        self.woken()
        return here

    def settle(self) -> None:
        """Where nothing waits any more, the catalogue's own rows count alone."""
        with self._remembering:
            if not self.outbox.names():
                self.forget_stand_ins()

    def _stand_in(self, here: object) -> None:
        """Know what waits as if it were there: a recording by its id and digest."""
        if isinstance(here, Take | TherapySession):
            self._stand_ins = {**self._stand_ins, here.id: here, here.sha256: here}
        elif isinstance(here, _HOLDS_AT_ONCE):
            self._here = (*self._here, here)

    def _whole(self, named: str) -> str:
        """The digest of a recording that waits: its id may be another one's once it arrives."""
        held = self._stand_ins.get(named)
        return named if held is None else held.sha256


def _unchained(utc_ns: int, actor: str, verb: str, subject: str, detail: str) -> AuditRow:
    return AuditRow(
        seq=0,
        utc_ns=utc_ns,
        actor=actor,
        verb=verb,
        subject=subject,
        detail=detail,
        previous_hash="",
        hash="",
    )
