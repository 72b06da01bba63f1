"""Outcome measures of patients: entered with a date, corrected by a new entry, compared with the first."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clock import local_day
from rehab_app.services.journal import check_corrected, check_past, corrects_of
from rehab_app.services.outcome_measures import Measure, measure
from rehab_app.services.outcome_series import Outcome, Series, series_of
from rehab_app.services.patients import side_named
from rehab_app.services.plain_text import many_lines
from sessions.catalogue import Catalogue, PatientEntry

__all__ = ["Outcome", "Outcomes", "Series"]

_MOST = 5000
_REMARK = 500


@dataclass(frozen=True, slots=True)
class _Kept:
    """What stands in the JSON of an entry; its topic is the measure."""

    value: float
    side: str
    place: str
    measured_on: str
    remark: str
    corrects: int = 0


class Outcomes:
    """Enters and reads outcome measures.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where it is noted that something was entered.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._clock_ns = clock_ns
        self._one_at_a_time = threading.Lock()

    def add(
        self,
        actor: Account,
        patient_id: str,
        key: str,
        value: float,
        *,
        side: str = "",
        place: str = "",
        measured_on: str = "",
        remark: str = "",
        corrects: int = 0,
    ) -> Outcome:
        """Enter a value.

        Args:
            actor: Who enters (verb "note").
            patient_id: Pseudonym.
            key: Key of the measure.
            value: In the measure's unit; ``Measure.read`` makes it of what was typed.
            side: Hand that was tested, empty where the measure has none.
            place: Joint, digit or kind of grip, empty where the measure has none.
            measured_on: ISO date, empty for today.
            remark: Anything else.
            corrects: Number of the entry that it takes the place of, 0 for none.

        Raises:
            Refused: The actor may not, a part is out of range, missing or too much, or the same was entered
                for that day already.
        """
        require(actor, "note")
        chosen = measure(key)
        today = local_day(self._clock_ns())
        check_past(
            "date of the measurement", measured_on, self._catalogue.patient(patient_id).birth_date, today
        )
        kept = _Kept(
            value=chosen.check(value),
            side=_side(chosen, side),
            place=_place(chosen, place),
            measured_on=measured_on or today.isoformat(),
            remark=many_lines("remark", remark, _REMARK),
            corrects=corrects,
        )
        content = json.dumps(asdict(kept), ensure_ascii=False)
        entry = PatientEntry(patient=patient_id, kind="outcome", topic=key, content=content, by=actor.name)
        with self._one_at_a_time:
            self._check_new(patient_id, chosen, kept)
            row = self._catalogue.add_entry(entry)
        done = f"{key}, entry {row.id}" + (f" in the place of {corrects}" if corrects else "")
        self._audit.note(actor, "write outcome", row.patient, done)
        return _outcome(row, 0)

    def list(self, patient_id: str, key: str = "", *, corrected: bool = False) -> tuple[Outcome, ...]:
        """Values, the newest measured first.

        Args:
            patient_id: Pseudonym.
            key: Only of this measure, empty for all.
            corrected: Whether those that were corrected are listed too.

        Raises:
            Refused: Patient or measure is unknown.
        """
        topic = measure(key).key if key else ""
        rows = self._catalogue.entries(patient_id, ("outcome",), topic=topic, limit=_MOST)
        replaced = {corrects_of(row): row.id for row in reversed(rows) if corrects_of(row)}
        found = [_outcome(row, replaced.get(row.id, 0)) for row in rows]
        kept = [one for one in found if corrected or not one.corrected_by]
        return tuple(sorted(kept, key=lambda one: (one.measured_on, one.id), reverse=True))

    def series(self, patient_id: str) -> tuple[Series, ...]:
        """Values by measure, hand and place, in the order of the measures; what was corrected is left out.

        Raises:
            Refused: The patient is unknown.
        """
        return series_of(reversed(self.list(patient_id)))

    def _check_new(self, patient_id: str, chosen: Measure, kept: _Kept) -> None:
        if kept.corrects:
            rows = self._catalogue.entries(patient_id, ("outcome",), topic=chosen.key, limit=_MOST)
            check_corrected(rows, kept.corrects)
        same = (kept.side, kept.place, kept.measured_on)
        for one in self.list(patient_id, chosen.key):
            if (one.side, one.place, one.measured_on) == same and one.id != kept.corrects:
                value = f"entered already for {kept.measured_on} ({chosen.text(one.value)}, entry {one.id})"
                what = " ".join(part for part in (chosen.words, kept.side, kept.place) if part)
                raise Refused(what, value, "one value a day", f"correct entry {one.id} instead")


def _side(chosen: Measure, side: str) -> str:
    if chosen.sided:
        return side_named(side)
    if side:
        raise Refused(f"side of {chosen.words}", repr(side[:40]), "left out", "it belongs to no single hand")
    return ""


def _place(chosen: Measure, place: str) -> str:
    if place == "" and not chosen.places:
        return ""
    if place not in chosen.places:
        known = f"one of {', '.join(chosen.places)}" if chosen.places else "left out"
        thing = f"place of {chosen.words}"
        raise Refused(thing, repr(place[:40]) if place else "not chosen", known, "choose it from the list")
    return place


def _outcome(row: PatientEntry, corrected_by: int) -> Outcome:
    try:
        kept = msgspec.json.decode(row.content, type=_Kept)
    except msgspec.MsgspecError as error:
        raise Refused(
            f"entry {row.id}", "damaged", "as it was written", "restore the catalogue from a backup"
        ) from error
    return Outcome(
        id=row.id,
        patient=row.patient,
        measure=measure(row.topic).key,
        value=kept.value,
        side=kept.side,
        place=kept.place,
        measured_on=kept.measured_on,
        remark=kept.remark,
        by=row.by,
        created_utc_ns=row.created_utc_ns,
        corrects=kept.corrects,
        corrected_by=corrected_by,
    )
