"""What each service is built of; it is imported and built when it is first used.

A property for each service, which imports its module: a command pays for what it uses, and neither simulation
nor reports cost anything to one that lists the accounts.
"""

from __future__ import annotations

from functools import cached_property, partial
from typing import TYPE_CHECKING

from rehab_app.services.wiring_records import RecordsWiring

if TYPE_CHECKING:
    from rehab_app.services.assessment import Assessment
    from rehab_app.services.kept_numbers import KeptNumbers
    from rehab_app.services.live import LiveDesk
    from rehab_app.services.population_norms import Norms
    from rehab_app.services.progress import Notebook, ProgressReports
    from rehab_app.services.proposals import Proposals
    from rehab_app.services.protocol_records import ProtocolRecords
    from rehab_app.services.protocols import Protocols
    from rehab_app.services.recompute import Recompute
    from rehab_app.services.repeatability import Repeatability
    from rehab_app.services.reports import Reports
    from rehab_app.services.runner import SessionRunner
    from rehab_app.services.runs import Runs
    from rehab_app.services.therapy import Therapy
    from rehab_app.services.wearer import Wearers


class Wiring(RecordsWiring):
    """What all services are built of: the records, therapy, reports and the live page."""

    def build_all(self) -> None:
        """Build every service now, so that no request waits for an import."""
        for kind in type(self).__mro__:
            for name, value in vars(kind).items():
                if isinstance(value, cached_property):
                    getattr(self, name)

    @cached_property
    def wearers(self) -> Wearers:
        """What a plan must respect of a patient."""
        from rehab_app.services.wearer import Wearers

        return Wearers(self.clinical, self.patient_limits)

    @cached_property
    def runs(self) -> Runs:
        """Runs, kept."""
        from rehab_app.services.runs import Runs

        return Runs(self.place, self.catalogue, self.audit, self.claims, self.stations.stamp)

    @cached_property
    def therapy(self) -> Therapy:
        """Plan, rehearse, play."""
        from rehab_app.services.planning import Planner
        from rehab_app.services.therapy import Therapy

        return Therapy(
            self.catalogue,
            self.takes,
            self.clinical,
            Planner(self.catalogue, self.wearers),
            self.runs,
            self.audit,
        )

    @cached_property
    def assessment(self) -> Assessment:
        """Sweeps that measure limits, fit checks."""
        from rehab_app.services.assessment import Assessment

        return Assessment(
            self.catalogue,
            self.clinical,
            self.wearers,
            self.patient_limits,
            self.therapy,
            self.runs,
            self.protocol_records,
        )

    @cached_property
    def protocol_records(self) -> ProtocolRecords:
        """What assessments found."""
        from rehab_app.services.protocol_records import ProtocolRecords

        return ProtocolRecords(self.catalogue, self.audit)

    @cached_property
    def protocols(self) -> Protocols:
        """Assessments whose results are kept."""
        from rehab_app.services.aside import aside
        from rehab_app.services.protocols import Protocols
        from sessions.metrics import measure_file

        measure = partial(aside, measure_file) if self.serving else measure_file
        return Protocols(self.protocol_records, self.assessment, self.therapy, measure)

    @cached_property
    def reports(self) -> Reports:
        """Reports of both."""
        from rehab_app.services.reports import Reports

        return Reports(self.place, self.catalogue, self.sessions, self.audit, serving=self.serving)

    @cached_property
    def notebook(self) -> Notebook:
        """What progress is read beside."""
        from rehab_app.services.progress import Notebook

        return Notebook(self.journal, self.outcomes, self.plans, self.protocol_records, self.norms)

    @cached_property
    def progress(self) -> ProgressReports:
        """Progress over sessions, comparisons."""
        from rehab_app.services.progress import ProgressReports

        return ProgressReports(self.place, self.catalogue, self.audit, self.notebook, serving=self.serving)

    @cached_property
    def repeatability(self) -> Repeatability:
        """How repeatable the numbers of this set-up are."""
        from rehab_app.services.repeatability import Repeatability

        return Repeatability(self.catalogue, self.sessions, self.audit)

    @cached_property
    def numbers(self) -> KeptNumbers:
        """Numbers of sealed files."""
        from rehab_app.services.kept_numbers import KeptNumbers

        return KeptNumbers(self.place, self.catalogue)

    @cached_property
    def recompute(self) -> Recompute:
        """Measures again what was recorded."""
        from rehab_app.services.recompute import Recompute

        bring = self.uploads.bring if self.settings.store.bucket else None
        return Recompute(self.catalogue, self.numbers, self.audit, self.settings.recompute, bring)

    @cached_property
    def norms(self) -> Norms:
        """What is usual among this clinic's patients."""
        from rehab_app.services.population_norms import Norms

        return Norms(self.catalogue, self.numbers, self.audit)

    @cached_property
    def proposals(self) -> Proposals:
        """The next step, made of the last sessions."""
        from rehab_app.services.proposals import Proposals

        return Proposals(self.catalogue, self.audit, self.progress, self.notebook)

    @cached_property
    def live(self) -> LiveDesk:
        """The live state machine."""
        from rehab_app.services.live import LiveDesk
        from rehab_app.services.live_work import Works

        works = Works(self.therapy, self.assessment, self.takes, self.claims, self.protocols)
        desk = LiveDesk(self.takes, works, self.audit, self.interrupted)
        self.closing.callback(desk.close)
        return desk

    @cached_property
    def runner(self) -> SessionRunner:
        """Leads through a session."""
        from rehab_app.services.runner import SessionRunner
        from rehab_app.services.runner_figures import note_figures
        from rehab_app.services.runner_note import Notes
        from rehab_app.services.runner_plan import SessionPlans

        plans = SessionPlans(self.plans, self.exercises, self.takes, self.clinical)
        figures = note_figures(serving=self.serving)
        notes = Notes(self.catalogue, self.journal, self.sessions, figures)
        return SessionRunner(self.place, self.patients, self.live, self.journal, plans, notes, self.audit)
