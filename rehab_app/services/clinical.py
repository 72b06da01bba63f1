"""Clinical records: diagnosis, tone, precautions; and modes that a therapist unlocks before their date."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import date

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clock import local_day
from rehab_app.services.diagnosis import check_mode, locks_of, template
from rehab_app.services.mode_locks import ModeLock, mode_locks
from rehab_app.services.plain_text import one_line
from robot_iface.types import DIGITS, MODES, Mode
from sessions.catalogue import Catalogue, ClinicalRecord, ModeUnlock, Patient

_BONE_M = (0.008, 0.08)
_BONES = 3
_LONGEST_REASON = 500


class Clinical:
    """What therapy must know of a patient's hand. Versions are added, none is changed.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where statements and unlocks are noted.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._clock_ns = clock_ns
        self._one_at_a_time = threading.Lock()

    def record(self, patient_id: str) -> ClinicalRecord | None:
        """The newest record, None where nobody stated one.

        Raises:
            Refused: The patient is unknown.
        """
        return next(iter(self._catalogue.clinical_records(patient_id)), None)

    def state(self, actor: Account, record: ClinicalRecord, since: int | None = None) -> ClinicalRecord:
        """State what is known of a hand now; ``by`` becomes the actor.

        Args:
            actor: Who states it (verb "prescribe").
            record: What is known.
            since: Version that the actor had read, 0 where there was none; None if it does not matter.

        Raises:
            Refused: The actor may not prescribe, the patient or diagnosis is unknown, the event lies in the
                future or before birth, the bones are those of no hand, or somebody stated another version
                since.
        """
        require(actor, "prescribe")
        template(record.diagnosis)
        _check_event(record.event_date, self._catalogue.patient(record.patient), self._today)
        if record.bones_m:
            bones_of(record)
        with self._one_at_a_time:
            _check_read(self.record(record.patient), since)
            kept = self._catalogue.add_clinical_record(replace(record, by=actor.name), since)
        self._audit.note(actor, "state clinical record", kept.patient, f"version {kept.id}, {kept.diagnosis}")
        return kept

    def records(self, patient_id: str) -> tuple[ClinicalRecord, ...]:
        """Every version of the record, newest first.

        Raises:
            Refused: The patient is unknown.
        """
        return self._catalogue.clinical_records(patient_id)

    def unlock(self, actor: Account, patient_id: str, mode: str, reason: str) -> ModeUnlock:
        """Let a mode be used before its date, for the diagnosis and event that are stated now.

        Raises:
            Refused: The actor is no therapist, the patient is unknown, no reason is given, or nothing is
                locked.
        """
        require(actor, "prescribe")
        record = self.record(patient_id)
        if record is None or _mode(mode) not in self.locks(patient_id):
            raise Refused(f"{mode} mode of {patient_id}", "not locked", "locked", "use it as it is")
        told = one_line("reason of the unlock", reason, _LONGEST_REASON)
        return self._decide(actor, record, mode, True, told)

    def lock(self, actor: Account, patient_id: str, mode: str) -> ModeUnlock:
        """Take an unlock back. Anyone may: it is the safer way.

        Raises:
            Refused: The patient is unknown, or nobody unlocked the mode.
        """
        record = self.record(patient_id)
        given = [one for one in self._catalogue.mode_unlocks(patient_id) if one.mode == _mode(mode)]
        if record is None or not given or not given[0].unlocked:
            bound = "unlocked by a therapist before"
            raise Refused(f"{mode} mode of {patient_id}", "not unlocked", bound, "leave it as it is")
        return self._decide(actor, record, mode, False, "")

    def locks(self, patient_id: str) -> dict[str, str]:
        """Modes that are locked today, each with its sentence.

        Raises:
            Refused: The patient is unknown.
        """
        record = self.record(patient_id)
        if record is None:
            return {}
        return locks_of(record, self._catalogue.mode_unlocks(patient_id), self._today)

    def mode_locks(self, patient_id: str) -> tuple[ModeLock, ...]:
        """Modes that the record closes at first, the open ones among them; empty without a record.

        Raises:
            Refused: The patient is unknown.
        """
        record = self.record(patient_id)
        if record is None:
            return ()
        return mode_locks(record, self._catalogue.mode_unlocks(patient_id), self._today)

    def check_mode(self, patient_id: str, mode: Mode) -> tuple[str, ...]:
        """Let a mode pass for a patient today; says who unlocked it where somebody had to.

        Raises:
            Refused: The patient is unknown, or the mode is locked.
        """
        record = self.record(patient_id)
        if record is None:
            return ()
        opened = check_mode(record, self._catalogue.mode_unlocks(patient_id), mode, self._today)
        return tuple(f"{mode} mode was unlocked by {one.by}: {one.reason}" for one in opened)

    @property
    def _today(self) -> date:
        return local_day(self._clock_ns())

    def _decide(
        self, actor: Account, record: ClinicalRecord, mode: str, unlocked: bool, reason: str
    ) -> ModeUnlock:
        kept = self._catalogue.add_mode_unlock(
            ModeUnlock(
                patient=record.patient,
                mode=mode,
                diagnosis=record.diagnosis,
                event_date=record.event_date,
                unlocked=unlocked,
                reason=reason,
                by=actor.name,
            )
        )
        self._audit.note(actor, "unlock mode" if unlocked else "lock mode", kept.patient, mode)
        return kept


def bones_of(record: ClinicalRecord) -> tuple[tuple[float, ...], ...]:
    """Measured bones, five digits of three; empty for average proportions.

    Raises:
        Refused: The text does not hold bones of a hand.
    """
    if not record.bones_m:
        return ()
    try:
        rows = tuple(tuple(float(length) for length in row) for row in json.loads(record.bones_m))
    except (TypeError, ValueError):
        rows = ()
    low, high = _BONE_M
    whole = len(rows) == len(DIGITS) and all(len(row) == _BONES for row in rows)
    if not whole or not all(math.isfinite(one) and low <= one <= high for row in rows for one in row):
        raise Refused(
            "bone lengths",
            repr(record.bones_m[:60]),
            f"{len(DIGITS)} digits of {_BONES} bones of {1e3 * low:.0f} to {1e3 * high:.0f} mm",
            "measure them again or leave them out",
        )
    return rows


def _check_read(newest: ClinicalRecord | None, since: int | None) -> None:
    """Refuse to state a record over one that the person has not read."""
    if since is not None and newest is not None and newest.id != since:
        value = f"stated anew by {newest.by} (version {newest.id}, yours was {since})"
        thing = f"clinical record of {newest.patient}"
        raise Refused(thing, value, "unchanged since you opened it", "compare and save again")


def _check_event(event_date: str, patient: Patient, today: date) -> None:
    if event_date > today.isoformat():
        raise Refused("event date", event_date, "today or before", "correct it")
    if event_date and patient.birth_date and event_date < patient.birth_date:
        raise Refused("event date", event_date, "after the patient's birth", "correct one of the dates")


def _mode(name: str) -> Mode:
    for mode in MODES:
        if mode == name:
            return mode
    raise Refused("mode", repr(name[:40]), "one of " + ", ".join(MODES), "choose one of them")
