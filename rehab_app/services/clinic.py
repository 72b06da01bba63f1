"""A clinic: its folder, catalogue and services."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from rehab_app.config import Settings
from sessions.catalogue import Catalogue

if TYPE_CHECKING:
    from rehab_app.services.accounts import Accounts
    from rehab_app.services.approvals import Approvals
    from rehab_app.services.assessment import Assessment
    from rehab_app.services.audit import Audit
    from rehab_app.services.calibrations import Calibrations, Hands
    from rehab_app.services.clinical import Clinical
    from rehab_app.services.devices import Devices
    from rehab_app.services.exercises import Exercises
    from rehab_app.services.journal import Journal
    from rehab_app.services.lease import ServerLease
    from rehab_app.services.limit_acts import LimitActs
    from rehab_app.services.limit_history import LimitHistory
    from rehab_app.services.live import LiveDesk
    from rehab_app.services.live_interrupted import Interrupted
    from rehab_app.services.marker_names import MarkerNames
    from rehab_app.services.outbox import Outbox
    from rehab_app.services.outcomes import Outcomes
    from rehab_app.services.patients import Patients
    from rehab_app.services.plans import Plans
    from rehab_app.services.population_norms import Norms
    from rehab_app.services.presentation import Presentation
    from rehab_app.services.privacy import Privacy
    from rehab_app.services.progress import ProgressReports
    from rehab_app.services.proposals import Proposals
    from rehab_app.services.protocols import Protocols
    from rehab_app.services.recompute import Recompute
    from rehab_app.services.repeatability import Repeatability
    from rehab_app.services.reports import Reports
    from rehab_app.services.retouching import Retouching
    from rehab_app.services.runner import SessionRunner
    from rehab_app.services.sessions import Sessions
    from rehab_app.services.stations import Stations
    from rehab_app.services.takes import Takes
    from rehab_app.services.therapy import Therapy
    from rehab_app.services.uploads import Uploads


@dataclass(frozen=True, slots=True)
class Clinic:
    """Everything that pages and commands may use; a context manager that closes it.

    Attributes:
        folder: The clinic folder.
        catalogue: Its catalogue.
        version: Version of the application.
        settings: What a person set of this installation.
        audit: The audit.
        accounts: Who may sign in.
        presentation: How the clinic presents itself: its name, its language.
        patients: Patients.
        clinical: What therapy must know of their hands.
        journal: Notes, pain, adverse events and check-ins.
        outcomes: Outcome measures that the clinic enters.
        limits: Limits of their joints.
        limit_history: How those came about.
        calibrations: Calibrated cameras.
        hands: Calibrated hands of persons.
        takes: Recorded demonstrations.
        approvals: Approvals that are taken back.
        exercises: The library of exercises.
        plans: Standing prescriptions of patients.
        devices: Cameras, robots and what is known of them.
        marker_names: Their markers, named by hand.
        retouching: New takes made of old ones.
        therapy: Plan, rehearse, play.
        assessment: Sweeps that measure limits, fit checks.
        protocols: Assessments whose results are kept: range, tone, tracking.
        sessions: Recorded therapy sessions.
        reports: Reports of both.
        progress: Progress over sessions, comparisons.
        proposals: The next step, made of the last sessions.
        repeatability: How repeatable the numbers of this set-up are.
        recompute: Measures again what was recorded.
        norms: What is usual among this clinic's patients.
        privacy: Backups, erasure, export, retention, consent.
        live: The live state machine.
        runner: Leads through a session.
        interrupted: Recordings that an ended server left unsealed.
        uploads: The object store that takes sealed recordings.
        stations: This station among the others, and who is in therapy where.
        outbox: What waits for the catalogue of a server.
        lease: The one server's lease, None where this is no server.
        closing: Ends the live work, where there is any.
    """

    folder: Path
    catalogue: Catalogue
    version: str
    settings: Settings
    audit: Audit
    accounts: Accounts
    presentation: Presentation
    patients: Patients
    clinical: Clinical
    journal: Journal
    outcomes: Outcomes
    limits: LimitActs
    limit_history: LimitHistory
    calibrations: Calibrations
    hands: Hands
    takes: Takes
    approvals: Approvals
    exercises: Exercises
    plans: Plans
    devices: Devices
    marker_names: MarkerNames
    retouching: Retouching
    therapy: Therapy
    assessment: Assessment
    protocols: Protocols
    sessions: Sessions
    reports: Reports
    progress: ProgressReports
    proposals: Proposals
    repeatability: Repeatability
    recompute: Recompute
    norms: Norms
    privacy: Privacy
    live: LiveDesk
    runner: SessionRunner
    interrupted: Interrupted
    uploads: Uploads
    stations: Stations
    outbox: Outbox
    lease: ServerLease | None = None
    closing: ExitStack = field(default_factory=ExitStack)

    def __enter__(self) -> Clinic:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End live work, write waiting audit rows, close the catalogue, give the lease back."""
        self.closing.close()
        self.audit.close()
        self.catalogue.close()
        if self.lease is not None:
            self.lease.release()
