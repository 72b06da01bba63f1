"""A clinic: its folder, catalogue and services."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from rehab_app.services.accounts import Accounts
from rehab_app.services.assessment import Assessment
from rehab_app.services.audit import Audit
from rehab_app.services.calibrations import Calibrations, Hands
from rehab_app.services.clinical import Clinical
from rehab_app.services.lease import ServerLease
from rehab_app.services.limit_acts import LimitActs
from rehab_app.services.live import LiveDesk
from rehab_app.services.marker_names import MarkerNames
from rehab_app.services.patients import Patients
from rehab_app.services.reports import Reports
from rehab_app.services.retouching import Retouching
from rehab_app.services.sessions import Sessions
from rehab_app.services.takes import Takes
from rehab_app.services.therapy import Therapy
from sessions.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class Clinic:
    """Everything that pages and commands may use; a context manager that closes it.

    Attributes:
        folder: The clinic folder.
        catalogue: Its catalogue.
        version: Version of the application.
        audit: The audit.
        accounts: Who may sign in.
        patients: Patients.
        clinical: What therapy must know of their hands.
        limits: Limits of their joints.
        calibrations: Calibrated cameras.
        hands: Calibrated hands of persons.
        takes: Recorded demonstrations.
        marker_names: Their markers, named by hand.
        retouching: New takes made of old ones.
        therapy: Plan, rehearse, play.
        assessment: Sweeps that measure limits, fit checks.
        sessions: Recorded therapy sessions.
        reports: Reports of both.
        live: The live state machine.
        lease: The one server's lease, None where this is no server.
    """

    folder: Path
    catalogue: Catalogue
    version: str
    audit: Audit
    accounts: Accounts
    patients: Patients
    clinical: Clinical
    limits: LimitActs
    calibrations: Calibrations
    hands: Hands
    takes: Takes
    marker_names: MarkerNames
    retouching: Retouching
    therapy: Therapy
    assessment: Assessment
    sessions: Sessions
    reports: Reports
    live: LiveDesk
    lease: ServerLease | None = None

    def __enter__(self) -> Clinic:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End live work, write waiting audit rows, close the catalogue, give the lease back."""
        self.live.close()
        self.audit.close()
        self.catalogue.close()
        if self.lease is not None:
            self.lease.release()
