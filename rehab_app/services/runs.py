"""A run of the motion process, kept: recorded, sealed, entered into the catalogue, remembered."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import msgspec

from rehab_app.access import Account
from rehab_app.config import ClinicFolder
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.limits_json import limits_to_json
from rehab_app.services.planning import assistance_to_json
from rehab_app.services.rows import PreparedPlan
from rehab_app.services.station_claims import Claims
from rehab_app.therapy.run import PlayResult, record_run, session_header
from robot_iface.build import capabilities
from robot_iface.link import MotionClient
from robot_iface.runtime import Message
from robot_iface.types import Certificate, RunEnd
from sessions.catalogue import AssistanceMemory, Catalogue, PrescriptionRow, TherapySession
from sessions.store import SessionReader

Watch: TypeAlias = Callable[[Message | RunEnd], None]


class Runs:
    """Runs plans and keeps what came of them.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where runs are noted.
        claims: Keeps a patient in therapy at one station only.
        stamp: Gives the JSON that says which station this is and how its clock stands.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        audit: Audit,
        claims: Claims,
        stamp: Callable[[], str],
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit
        self._claims = claims
        self._stamp = stamp

    def run(
        self,
        client: MotionClient,
        prepared: PreparedPlan,
        certificate: Certificate,
        actor: Account,
        out: Path | None = None,
        watch: Watch | None = None,
    ) -> PlayResult:
        """Run to the end, seal, enter; blocks until it is done or stopped.

        Args:
            client: The motion process.
            prepared: What is run.
            certificate: Of its rehearsal.
            actor: Who runs it.
            out: A copy for the user.
            watch: Told every message besides.

        Raises:
            Refused: The certificate is not that of the plan, the patient is in therapy at another station,
                or the motion process failed.
        """
        with self._claims.held(prepared.patient_id):
            return self._run(client, prepared, certificate, actor, out, watch)

    def _run(
        self,
        client: MotionClient,
        prepared: PreparedPlan,
        certificate: Certificate,
        actor: Account,
        out: Path | None,
        watch: Watch | None,
    ) -> PlayResult:
        subject = prepared.take_id or prepared.patient_id
        self._audit.note(actor, "play", subject, f"{prepared.plan.prescription.mode} {certificate.digest}")
        device = capabilities(prepared.plan.device)
        header = session_header(
            prepared.plan,
            certificate,
            prepared.geometry,
            prepared.exercise,
            prepared.patient_id or "demonstration",
            device,
            self._prescription_of(prepared.take_id),
        )
        header = replace(header, station=self._stamp())
        client.start(prepared.plan, certificate)
        ends: list[RunEnd] = []
        result = record_run(
            _overheard(client.messages(), ends, watch),
            storage.new_file(self._folder.sessions),
            header,
            prepared.plan,
            prepared.geometry,
            device,
        )
        kept = self._keep(result, prepared, header.utc_start_ns, actor)
        self._remember(prepared, kept.session, ends)
        if out is not None:
            storage.copy_sealed(result.path, out, result.sha256)
        return replace(kept, path=result.path if out is None else out)

    def order(self, prepared: PreparedPlan, actor: Account) -> None:
        """Keep what was ordered for a patient of the clinic."""
        if not (prepared.patient_id and prepared.take_id):
            return
        asked = prepared.plan.prescription
        self._catalogue.add_prescription(
            PrescriptionRow(
                patient=prepared.patient_id,
                take=prepared.take_id,
                mode=asked.mode,
                speed=asked.speed,
                repetitions=asked.repetitions,
                stiffness_multiple=asked.stiffness_multiple,
                limits=limits_to_json(prepared.plan.limits),
                content=msgspec.json.encode(asked).decode(),
                by=actor.name,
            )
        )

    def _prescription_of(self, take_id: str) -> str:
        """What the header of a take prescribes, such as the target of a computed grasp; mostly nothing."""
        if not take_id:
            return ""
        with SessionReader(self._folder.root / self._catalogue.take(take_id).path) as reader:
            return reader.header.prescription

    def _keep(
        self, result: PlayResult, prepared: PreparedPlan, utc_start_ns: int, actor: Account
    ) -> PlayResult:
        entered = self._catalogue.add_session(
            TherapySession(
                patient=prepared.patient_id,
                take=prepared.take_id,
                sha256=result.sha256,
                path=result.path.relative_to(self._folder.root).as_posix(),
                mode=result.mode,
                started_utc_ns=utc_start_ns,
            )
        )
        ended = "completed" if result.completed else "ended early"
        self._audit.note(actor, "session", entered.id, ended)
        return replace(result, session=entered.id)

    def _remember(self, prepared: PreparedPlan, session: str, ends: list[RunEnd]) -> None:
        """Where the next session of this exercise begins; what was broken off says nothing of ability."""
        end = ends[0] if ends else None
        if end is None or not (end.completed and end.assistance and prepared.patient_id):
            return
        self._catalogue.add_assistance(
            AssistanceMemory(
                patient=prepared.patient_id,
                exercise=prepared.exercise,
                device=prepared.plan.device,
                content=assistance_to_json(end.assistance),
                session=session,
            )
        )


def _overheard(
    messages: Iterator[Message | RunEnd], ends: list[RunEnd], watch: Watch | None
) -> Iterator[Message | RunEnd]:
    """The same messages; the end is kept, and whoever watches is told."""
    for message in messages:
        if isinstance(message, RunEnd):
            ends.append(message)
        if watch is not None:
            watch(message)
        yield message
