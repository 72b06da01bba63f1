"""Whose screen an account of the role patient is: it names this patient and exercise, nobody else's."""

from __future__ import annotations

import msgspec

from rehab_app.access import Account, Role
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue, Setting
from sessions.catalogue.erasure import OWN_PATIENT

PATIENT: Role = "patient"


class OwnPatients:
    """Ties accounts to patients.

    A tie is a setting under the account's number. The audit names the patient by pseudonym and the account by
    number: a sign-in name may be the patient's own, and the audit outlives erasure. Archiving or erasing a
    patient unties.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where ties are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def of(self, account: Account) -> str:
        """Pseudonym of the patient whose screen it is, "" where it is nobody's."""
        if account.role != PATIENT:
            return ""
        return self._kept(OWN_PATIENT + account.id)

    def check(self, role: Role, typed: str) -> str:
        """The pseudonym that somebody typed for an account of that role, "" where nothing was typed.

        Raises:
            Refused: The patient is unknown or archived, or the role has no patient.
        """
        patient = typed.strip().upper()
        if patient and role != PATIENT:
            raise Refused(
                "patient of the account",
                f"given with the role {role}",
                "given with the role patient only",
                "leave it empty, or choose that role",
            )
        if not patient:
            return ""
        known = self._catalogue.patient(patient)
        if known.archived:
            remedy = "put the patient back into the list first"
            raise Refused("patient of the account", "archived", "one of the list", remedy)
        return known.id

    def release(self, patient: str, by: Account) -> None:
        """Untie every account from a patient; asked for the verb by whoever calls.

        Args:
            patient: Pseudonym.
            by: Who does it.
        """
        for user in self._catalogue.users():
            if self._kept(OWN_PATIENT + str(user.id)) == patient:
                self.tie(Account(user.name, PATIENT, str(user.id)), "", by)

    def tie(self, account: Account, patient: str, by: Account) -> None:
        """Make an account the screen of one patient, or of nobody.

        Args:
            account: The account.
            patient: What ``check`` gave.
            by: Who does it; asked for the verb by whoever calls.
        """
        key = OWN_PATIENT + account.id
        before = self._kept(key)
        if before == patient:
            return
        self._catalogue.set(Setting(key=key, content=msgspec.json.encode(patient).decode(), by=by.name))
        verb, subject = ("tie screen", patient) if patient else ("untie screen", before)
        self._audit.note(by, verb, subject, f"account {account.id}")

    def _kept(self, key: str) -> str:
        kept = self._catalogue.setting(key)
        return "" if kept is None else msgspec.json.decode(kept.content, type=str)
