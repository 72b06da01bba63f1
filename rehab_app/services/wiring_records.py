"""What the services of the records are built of; each is imported and built when it is first used.

A property for each service, which imports its module: a command pays for what it uses, and neither simulation
nor reports cost anything to one that lists the accounts.
"""

from __future__ import annotations

from contextlib import ExitStack
from functools import cached_property
from typing import TYPE_CHECKING

from rehab_app import __version__
from rehab_app.config import ClinicFolder, Settings
from rehab_app.services.outbox_catalogue import open_catalogue
from rehab_app.services.tally import CountedAudit

if TYPE_CHECKING:
    from rehab_app.services.accounts import Accounts
    from rehab_app.services.approvals import Approvals
    from rehab_app.services.backup import Backups
    from rehab_app.services.calibrations import Calibrations, Hands
    from rehab_app.services.clinical import Clinical
    from rehab_app.services.devices import Devices
    from rehab_app.services.erasure import Erasures
    from rehab_app.services.exercises import Exercises
    from rehab_app.services.journal import Journal
    from rehab_app.services.limit_acts import LimitActs
    from rehab_app.services.limit_history import LimitHistory
    from rehab_app.services.live_interrupted import Interrupted
    from rehab_app.services.marker_names import MarkerNames
    from rehab_app.services.outbox import Outbox
    from rehab_app.services.outcomes import Outcomes
    from rehab_app.services.patient_limits import PatientLimits
    from rehab_app.services.patients import Patients
    from rehab_app.services.plans import Plans
    from rehab_app.services.presentation import Presentation
    from rehab_app.services.privacy import Privacy
    from rehab_app.services.retouching import Retouching
    from rehab_app.services.sessions import Sessions
    from rehab_app.services.station_claims import Claims
    from rehab_app.services.stations import Stations
    from rehab_app.services.takes import Takes
    from rehab_app.services.uploads import Uploads


class RecordsWiring:
    """What the services are built of that keep the clinic's records.

    Args:
        place: The clinic folder.
        serving: Whether this is the server, which renders reports in a process of their own.
        settings: What a person set of this installation.
    """

    def __init__(self, place: ClinicFolder, serving: bool, settings: Settings) -> None:
        self.place = place
        self.serving = serving
        self.settings = settings
        self.catalogue = open_catalogue(place.root, settings.catalogue_url)
        self.audit = CountedAudit(self.catalogue)
        self.closing = ExitStack()

    @cached_property
    def accounts(self) -> Accounts:
        """Who may sign in."""
        from rehab_app.services.accounts import Accounts

        return Accounts(self.catalogue, self.audit)

    @cached_property
    def presentation(self) -> Presentation:
        """How the clinic presents itself."""
        from rehab_app.services.presentation import Presentation

        return Presentation(self.catalogue, self.audit)

    @cached_property
    def patients(self) -> Patients:
        """Patients."""
        from rehab_app.services.patients import Patients

        return Patients(self.catalogue, self.audit)

    @cached_property
    def clinical(self) -> Clinical:
        """What therapy must know of their hands."""
        from rehab_app.services.clinical import Clinical

        return Clinical(self.catalogue, self.audit)

    @cached_property
    def journal(self) -> Journal:
        """Notes, pain, adverse events and check-ins."""
        from rehab_app.services.journal import Journal

        return Journal(self.catalogue, self.audit)

    @cached_property
    def outcomes(self) -> Outcomes:
        """Outcome measures that the clinic enters."""
        from rehab_app.services.outcomes import Outcomes

        return Outcomes(self.catalogue, self.audit)

    @cached_property
    def patient_limits(self) -> PatientLimits:
        """What is kept of the limits of their joints."""
        from rehab_app.services.patient_limits import PatientLimits

        return PatientLimits(self.catalogue, self.audit)

    @cached_property
    def limits(self) -> LimitActs:
        """Limits of their joints."""
        from rehab_app.services.limit_acts import LimitActs

        return LimitActs(self.catalogue, self.clinical, self.patient_limits)

    @cached_property
    def limit_history(self) -> LimitHistory:
        """How those came about."""
        from rehab_app.services.limit_history import LimitHistory

        return LimitHistory(self.catalogue, self.limits)

    @cached_property
    def calibrations(self) -> Calibrations:
        """Calibrated cameras."""
        from rehab_app.services.calibrations import Calibrations

        return Calibrations(self.catalogue, self.audit)

    @cached_property
    def hands(self) -> Hands:
        """Calibrated hands of persons."""
        from rehab_app.services.calibrations import Hands

        return Hands(self.catalogue, self.audit)

    @cached_property
    def takes(self) -> Takes:
        """Recorded demonstrations."""
        from rehab_app.services.takes import Takes

        stamp = self.stations.stamp
        return Takes(self.place, self.catalogue, self.audit, self.calibrations, self.hands, stamp)

    @cached_property
    def approvals(self) -> Approvals:
        """Approvals that are taken back."""
        from rehab_app.services.approvals import Approvals

        return Approvals(self.catalogue, self.audit)

    @cached_property
    def exercises(self) -> Exercises:
        """The library of exercises."""
        from rehab_app.services.exercises import Exercises

        return Exercises(self.catalogue, self.audit)

    @cached_property
    def plans(self) -> Plans:
        """Standing prescriptions of patients."""
        from rehab_app.services.plans import Plans

        return Plans(self.catalogue, self.audit, self.takes, self.exercises, self.clinical)

    @cached_property
    def devices(self) -> Devices:
        """Cameras, robots and what is known of them."""
        from rehab_app.services.devices import Devices

        return Devices(self.catalogue, self.calibrations)

    @cached_property
    def marker_names(self) -> MarkerNames:
        """Their markers, named by hand."""
        from rehab_app.services.marker_names import MarkerNames

        return MarkerNames(self.place, self.takes, self.calibrations)

    @cached_property
    def retouching(self) -> Retouching:
        """New takes made of old ones."""
        from rehab_app.services.retouching import Retouching

        return Retouching(self.place, self.takes)

    @cached_property
    def sessions(self) -> Sessions:
        """Recorded therapy sessions."""
        from rehab_app.services.sessions import Sessions

        bring = self.uploads.bring if self.settings.store.bucket else None
        return Sessions(self.place, self.catalogue, bring)

    @cached_property
    def backups(self) -> Backups:
        """Encrypted backups."""
        from rehab_app.services.backup import Backups

        return Backups(self.place, self.catalogue, self.audit, __version__)

    @cached_property
    def erasures(self) -> Erasures:
        """Erasing one patient."""
        from rehab_app.services.erasure import Erasures

        return Erasures(self.place, self.catalogue, self.audit)

    @cached_property
    def privacy(self) -> Privacy:
        """Backups, erasure, export, retention, consent."""
        from rehab_app.services.backup_place import BackupPlace
        from rehab_app.services.consents import Consents
        from rehab_app.services.patient_export import PatientExports
        from rehab_app.services.privacy import Privacy
        from rehab_app.services.retention import Retention

        return Privacy(
            self.backups,
            BackupPlace(self.place, self.catalogue, self.backups, self.audit),
            self.erasures,
            PatientExports(self.place, self.catalogue, self.audit),
            Retention(self.catalogue, self.audit),
            Consents(self.place, self.catalogue, self.takes, self.audit),
        )

    @cached_property
    def uploads(self) -> Uploads:
        """The object store that takes sealed recordings."""
        from rehab_app.services.uploads import Uploads

        return Uploads(self.place, self.catalogue, self.audit, self.settings.store)

    @cached_property
    def interrupted(self) -> Interrupted:
        """Recordings that an ended server left unsealed."""
        from rehab_app.services.live_interrupted import Interrupted

        return Interrupted(self.place, self.catalogue, self.takes, self.audit)

    @cached_property
    def outbox(self) -> Outbox:
        """What waits for the catalogue of a server."""
        from rehab_app.services.outbox import Outbox

        outbox = Outbox(self.catalogue)
        self.closing.callback(outbox.close)
        return outbox

    @cached_property
    def claims(self) -> Claims:
        """Which patients are in therapy here."""
        from rehab_app.services.station_claims import Claims, identity_of
        from rehab_app.services.station_marks import StationMarks

        me = identity_of(self.settings.station_name, __version__)
        claims = Claims(self.catalogue, self.audit, me, StationMarks(self.place.root, me.holder))
        self.closing.callback(claims.close)
        return claims

    @cached_property
    def stations(self) -> Stations:
        """This station among the others."""
        from rehab_app.services.stations import Stations

        stations = Stations(self.catalogue, self.claims)
        self.closing.callback(stations.close)
        return stations
