"""The journal of a patient: entries are added; a correction is a new entry that names the old one."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from datetime import date

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clock import local_day
from rehab_app.services.journal_records import KINDS, AdverseEvent, CheckIn, Note, PainReport, Written
from sessions.catalogue import Catalogue, PatientEntry

__all__ = ["AdverseEvent", "CheckIn", "Entry", "Journal", "Note", "PainPoint", "PainReport"]

_MOST = 5000
_NOT_TWICE = ("note", "adverse-event")
_TWICE_NS = 600_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One entry of the journal.

    Attributes:
        id: Its number.
        patient: Pseudonym.
        kind: note, pain, adverse-event or check-in.
        session: Therapy session that it belongs to, empty for none.
        what: What was written.
        by: Who wrote it.
        created_utc_ns: When.
        corrects: Number of the entry that it takes the place of, 0 for none.
        corrected_by: Number of the entry that took its place, 0 while it holds.
    """

    id: int
    patient: str
    kind: str
    session: str
    what: Written
    by: str
    created_utc_ns: int
    corrects: int = 0
    corrected_by: int = 0


@dataclass(frozen=True, slots=True)
class PainPoint:
    """One pain score of the course over time.

    Attributes:
        utc_ns: When it was given.
        score: 0 to 10.
        when: before, during, after, rest, or empty.
        place: Where it hurt, may be empty.
        source: Kind of the entry.
    """

    utc_ns: int
    score: int
    when: str
    place: str
    source: str


class Journal:
    """Writes and reads the journal.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where it is noted that something was written, never what.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._clock_ns = clock_ns
        self._one_at_a_time = threading.Lock()

    def note(
        self, actor: Account, patient_id: str, text: str, *, session: str = "", corrects: int = 0
    ) -> Entry:
        """Write a note.

        Raises:
            Refused: The actor may not, the text cannot be kept or was written just now already, or patient,
                session or old entry is unknown.
        """
        require(actor, "note")
        return self._add(actor, patient_id, "note", Note(text), session, corrects)

    def pain(
        self, actor: Account, patient_id: str, report: PainReport, *, session: str = "", corrects: int = 0
    ) -> Entry:
        """Write a pain: anybody may; to correct one needs the verb "note".

        Raises:
            Refused: As for a note.
        """
        require(actor, "note" if corrects else "stop")
        return self._add(actor, patient_id, "pain", report, session, corrects)

    def adverse_event(
        self, actor: Account, patient_id: str, event: AdverseEvent, *, session: str = "", corrects: int = 0
    ) -> Entry:
        """Write an adverse event.

        Raises:
            Refused: As for a note.
        """
        require(actor, "note")
        return self._add(actor, patient_id, "adverse-event", event, session, corrects)

    def check_in(
        self, actor: Account, patient_id: str, answers: CheckIn, *, session: str = "", corrects: int = 0
    ) -> Entry:
        """Write the answers before a session.

        Raises:
            Refused: As for a note; or the date of the injection is none, lies ahead or before birth.
        """
        require(actor, "note")
        born = self._catalogue.patient(patient_id).birth_date
        check_past("botulinum date", answers.botulinum_date, born, local_day(self._clock_ns()))
        return self._add(actor, patient_id, "check-in", answers, session, corrects)

    def entries(
        self, patient_id: str, kinds: Iterable[str] = tuple(KINDS), *, session: str = "", limit: int = 500
    ) -> tuple[Entry, ...]:
        """Entries, newest first; those that were corrected say by which.

        Args:
            patient_id: Pseudonym.
            kinds: Which kinds.
            session: Only of this therapy session, empty for all.
            limit: At most so many.

        Raises:
            Refused: The patient is unknown, or a kept entry is damaged.
        """
        rows = self._catalogue.entries(patient_id, tuple(kinds), session=session, limit=_MOST)
        replaced = {corrects_of(row): row.id for row in reversed(rows) if corrects_of(row)}
        return tuple(_entry(row, replaced.get(row.id, 0)) for row in rows[:limit])

    def latest_check_in(self, patient_id: str) -> Entry | None:
        """The newest check-in, None before the first.

        Raises:
            Refused: The patient is unknown.
        """
        return next(iter(self.entries(patient_id, ("check-in",), limit=1)), None)

    def pain_course(self, patient_id: str) -> tuple[PainPoint, ...]:
        """Every pain score of a patient, oldest first; what was corrected is left out.

        Raises:
            Refused: The patient is unknown.
        """
        held = self.entries(patient_id, ("pain", "check-in"), limit=_MOST)
        points = [_point(one) for one in held if not one.corrected_by]
        return tuple(sorted((one for one in points if one is not None), key=lambda one: one.utc_ns))

    def _add(
        self, actor: Account, patient_id: str, kind: str, what: Written, session: str, corrects: int
    ) -> Entry:
        content = json.dumps({**asdict(what), "corrects": corrects}, ensure_ascii=False)
        entry = PatientEntry(patient=patient_id, kind=kind, session=session, content=content, by=actor.name)
        with self._one_at_a_time:
            held = self._held(patient_id, kind, corrects)
            if corrects:
                check_corrected(held, corrects)
            elif kind in _NOT_TWICE:
                self._check_new(held, entry)
            row = self._catalogue.add_entry(entry)
        done = f"entry {row.id}" if row.id else "an entry that waits for the catalogue"
        done += f" in the place of {corrects}" if corrects else ""
        self._audit.note(actor, f"write {kind}", row.patient, done)
        return _entry(row, 0)

    def _held(self, patient_id: str, kind: str, corrects: int) -> tuple[PatientEntry, ...]:
        """What there is of that kind; nothing while the catalogue does not answer, save for a correction."""
        try:
            return self._catalogue.entries(patient_id, (kind,), limit=_MOST)
        except NoAnswer:
            if corrects:
                raise
            self._catalogue.patient(patient_id)
            return ()

    def _check_new(self, held: tuple[PatientEntry, ...], entry: PatientEntry) -> None:
        """Refuse what the same person wrote word by word just now: a form that was sent twice."""
        since_ns = self._clock_ns() - _TWICE_NS
        for row in held:
            same = (row.content, row.by, row.session) == (entry.content, entry.by, entry.session)
            if same and row.created_utc_ns >= since_ns:
                raise Refused(entry.kind, f"written already as entry {row.id}", "new", "leave it as it is")


def check_corrected(rows: Iterable[PatientEntry], corrects: int) -> None:
    """Refuse to correct an entry that is not there, or not the newest word.

    Args:
        rows: Entries of the same patient and kind.
        corrects: Number of the entry that is to be corrected.

    Raises:
        Refused: It is not among them, or was corrected already.
    """
    held = tuple(rows)
    if corrects not in {row.id for row in held}:
        raise Refused(f"entry {corrects}", "unknown", "an entry of this kind and patient", "look at the list")
    newer = next((row.id for row in held if corrects_of(row) == corrects), 0)
    if newer:
        raise Refused(
            f"entry {corrects}", f"corrected already by entry {newer}", "the newest word", f"correct {newer}"
        )


def check_past(thing: str, text: str, born: str, today: date) -> None:
    """Refuse a date, ISO or empty, that is none, lies ahead or before birth.

    Raises:
        Refused: So it is.
    """
    if not text:
        return
    try:
        day = date.fromisoformat(text).isoformat()
    except ValueError:
        raise Refused(thing, repr(text[:40]), "a date as YYYY-MM-DD", "correct it") from None
    if day > today.isoformat():
        raise Refused(thing, day, "today or before", "correct it")
    if born and day < born:
        raise Refused(thing, day, "after the patient's birth", "correct it")


def corrects_of(row: PatientEntry) -> int:
    """Number of the entry that a row takes the place of, 0 for none."""
    found = json.loads(row.content).get("corrects", 0)
    return found if isinstance(found, int) else 0


def _entry(row: PatientEntry, corrected_by: int) -> Entry:
    try:
        what = msgspec.json.decode(row.content, type=KINDS[row.kind])
    except msgspec.MsgspecError as error:
        raise Refused(
            f"entry {row.id}", "damaged", "as it was written", "restore the catalogue from a backup"
        ) from error
    return Entry(
        id=row.id,
        patient=row.patient,
        kind=row.kind,
        session=row.session,
        what=what,
        by=row.by,
        created_utc_ns=row.created_utc_ns,
        corrects=corrects_of(row),
        corrected_by=corrected_by,
    )


def _point(entry: Entry) -> PainPoint | None:
    what = entry.what
    if isinstance(what, PainReport) and what.score is not None:
        return PainPoint(entry.created_utc_ns, what.score, what.when, what.place, entry.kind)
    if isinstance(what, CheckIn) and what.pain is not None:
        return PainPoint(entry.created_utc_ns, what.pain, "before", "", entry.kind)
    return None
