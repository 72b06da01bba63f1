"""Erasing one patient: rows, files, reports, and, by a ledger beside them, whatever backups still hold."""

from __future__ import annotations

from pathlib import Path

import msgspec

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.erased_ledger import LEDGER, add_to_ledger, ledger, line_of
from rehab_app.services.object_queue import withdraw
from rehab_app.services.population_kept import withdraw_norms
from sessions.catalogue import Catalogue, Setting
from sessions.catalogue.erasure import UNFINISHED, Belongings

OBJECT = "object:"
"""Begins what is left to delete in an object store: room and digest."""


class Erasures:
    """Erases patients.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where erasures are noted, by pseudonym.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue, audit: Audit) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit

    def belongings(self, actor: Account, patient_id: str) -> Belongings:
        """What erasing would take away.

        Raises:
            Refused: The actor may not erase, or the patient is unknown.
        """
        require(actor, "erase")
        return self._catalogue.belongings(patient_id)

    def erase(self, actor: Account, patient_id: str, confirmed: str) -> Belongings:
        """Erase a patient: every row, session, report and cached number, and takes of the patient's own hand.

        Takes that others' therapy uses stay without a link to the patient. The pseudonym and the act stay in
        the audit. A crash on the way is finished at the next start.

        Args:
            actor: Who erases (verb "erase").
            patient_id: Pseudonym.
            confirmed: The pseudonym once more, typed by a person.

        Raises:
            Refused: The actor may not, the patient is unknown, or what was typed is not the pseudonym.
        """
        require(actor, "erase")
        if confirmed.strip() != patient_id:
            raise Refused(
                "confirmation",
                repr(confirmed[:40]),
                f"the pseudonym {patient_id}",
                "type it to erase for good",
            )
        found = self._catalogue.belongings(patient_id)
        add_to_ledger(self._folder.root / LEDGER, (line_of(found.patient, found.created_utc_ns),))
        paths = [path for path, _ in (*found.sessions, *found.takes)]
        left = [*paths, *(f"{OBJECT}sessions/{sha256}" for _, sha256 in found.sessions)]
        left += [f"{OBJECT}takes/{sha256}" for _, sha256 in found.takes]
        withdraw_norms(self._catalogue, actor.name)  # a patient's numbers leave them too
        self._catalogue.erase_patient(patient_id, msgspec.json.encode(left).decode(), actor.name)
        self.finish()
        self._audit.note(actor, "erase patient", patient_id, f"{len(paths)} files")
        return found

    def finish(self) -> None:
        """Delete files that an erasure left behind when it was interrupted; nothing otherwise."""
        kept = self._catalogue.setting(UNFINISHED)
        if kept is None or kept.content == "[]":
            return
        for path in msgspec.json.decode(kept.content, type=list[str]):
            if path.startswith(OBJECT):
                withdraw(self._folder.root, path.removeprefix(OBJECT))
            else:
                self._delete(self._folder.root / path)
        self._catalogue.set(Setting(key=UNFINISHED, content="[]", by=kept.by))

    def erase_again(self, actor: Account, *beside: Path) -> tuple[str, ...]:
        """Erase whom a ledger names and a restored backup brought back.

        Args:
            actor: Who restored.
            beside: Further ledgers, such as the one beside the backup.

        Returns:
            Pseudonyms that were erased again.
        """
        require(actor, "erase")
        add_to_ledger(self._folder.root / LEDGER, tuple(line for path in beside for line in ledger(path)))
        wanted = set(ledger(self._folder.root / LEDGER))
        again: list[str] = []
        for patient in (*self._catalogue.patients(), *self._catalogue.patients(archived=True)):
            named = bool(patient.family_name or patient.given_name or patient.birth_date)
            if named and line_of(patient.id, patient.created_utc_ns) in wanted:
                self.erase(actor, patient.id, patient.id)
                again.append(patient.id)
        return tuple(again)

    def _delete(self, path: Path) -> None:
        """A sealed file, its digest and its reports."""
        path.unlink(missing_ok=True)
        storage.digest_beside(path).unlink(missing_ok=True)
        for report in self._folder.reports.rglob(f"*{path.stem}*"):
            if report.is_file():
                report.unlink(missing_ok=True)
