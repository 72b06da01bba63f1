"""Norms of this clinic: made of everything that was measured, kept, and cited by reports."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec

from rehab_app.access import Account, require
from rehab_app.services.audit import Audit
from rehab_app.services.clock import local_day
from rehab_app.services.kept_numbers import KeptNumbers
from rehab_app.services.population import Group, Norm, Sample, age_band, norms_of
from rehab_app.services.population_kept import KEY
from sessions.catalogue import Catalogue, ClinicalRecord, Patient, Setting, TherapySession
from sessions.reports.past import Past, past_version


@dataclass(frozen=True, slots=True)
class _Kept:
    """Norms as they are kept."""

    version: str
    norms: tuple[Norm, ...] = ()


class Norms:
    """What is usual among the patients of this clinic.

    Args:
        catalogue: Patients, sessions, and where norms are kept.
        numbers: Numbers of sessions.
        audit: Where making them is noted.
    """

    def __init__(self, catalogue: Catalogue, numbers: KeptNumbers, audit: Audit) -> None:
        self._catalogue = catalogue
        self._numbers = numbers
        self._audit = audit

    def renew(self, actor: Account) -> tuple[Norm, ...]:
        """Make the norms anew from the numbers that are kept of the present version.

        Args:
            actor: Who asks (verb "approve").

        Raises:
            Refused: The actor may not.
        """
        require(actor, "approve")
        patients = (*self._catalogue.patients(), *self._catalogue.patients(archived=True))
        found = norms_of(sample for patient in patients for sample in self._samples(patient))
        content = msgspec.json.encode(_Kept(past_version(), found)).decode()
        self._catalogue.set(Setting(key=KEY, content=content, by=actor.name))
        self._audit.note(actor, "renew norms", "", f"{len(found)} groups")
        return found

    def all(self) -> tuple[Norm, ...]:
        """The norms that were made last; none of another version of the methods, or since an erasure."""
        kept = self._catalogue.setting(KEY)
        if kept is None:
            return ()
        found = msgspec.json.decode(kept.content, type=_Kept)
        return found.norms if found.version == past_version() else ()

    def beside(self, past: Past, mode: str) -> tuple[Norm, ...]:
        """The norms that a patient's session may be read beside: same age, side, diagnosis and mode.

        Args:
            past: The session.
            mode: Its therapy mode in the catalogue.

        Raises:
            Refused: Its patient is unknown.
        """
        patient = self._catalogue.patient(past.subject_id)
        records = self._catalogue.clinical_records(patient.id)
        asked = {sample.group for sample in _samples(patient, past, mode, records)}
        return tuple(norm for norm in self.all() if norm.group in asked)

    def _samples(self, patient: Patient) -> Iterator[Sample]:
        rows = self._catalogue.sessions(patient.id)
        records = self._catalogue.clinical_records(patient.id)
        pasts = self._numbers.pasts(self._numbers.works(rows))
        for row in rows:
            past = pasts.get(row.sha256)
            if past is not None and _belongs(past, patient, row):
                yield from _samples(patient, past, row.mode, records)


def _belongs(past: Past, patient: Patient, row: TherapySession) -> bool:
    return not past.reason and past.sha256 == row.sha256 and past.subject_id == patient.id


def _samples(
    patient: Patient, past: Past, mode: str, records: tuple[ClinicalRecord, ...]
) -> Iterator[Sample]:
    """Numbers of a session that nothing speaks against; none of a patient whose age is unknown."""
    age_from = age_band(patient.birth_date, local_day(past.utc_start_ns))
    if age_from is None:
        return
    diagnosis = _diagnosis(records, past.utc_start_ns)
    for one in past.numbers:
        if one.value is not None and one.status == "ok":
            group = Group(one.name, one.subject, one.source, mode, age_from, past.side, diagnosis)
            yield Sample(group, patient.id, past.utc_start_ns, one.value)


def _diagnosis(records: tuple[ClinicalRecord, ...], utc_ns: int) -> str:
    """What was stated last before the session, else first after it; empty where nothing ever was."""
    before = [record for record in records if record.created_utc_ns <= utc_ns]
    return before[0].diagnosis if before else records[-1].diagnosis if records else ""
