"""What is kept of people and for how long: backups, erasure, export, retention, consent."""

from __future__ import annotations

from dataclasses import dataclass

from rehab_app.services.backup import Backups
from rehab_app.services.backup_place import BackupPlace
from rehab_app.services.consents import Consents
from rehab_app.services.erasure import Erasures
from rehab_app.services.patient_export import PatientExports
from rehab_app.services.retention import Retention


@dataclass(frozen=True, slots=True)
class Privacy:
    """The services of privacy.

    Attributes:
        backups: Encrypted backups.
        place: Where those of the browser lie.
        erasures: Erasing one patient.
        exports: Everything about one patient as a file.
        retention: How long patients are kept.
        consents: What patients agree to.
    """

    backups: Backups
    place: BackupPlace
    erasures: Erasures
    exports: PatientExports
    retention: Retention
    consents: Consents
