"""Therapy: fit a take to a patient, rehearse, play."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rehab_app import __version__
from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.planning import Order, prepare
from rehab_app.services.rows import PreparedPlan, TakeRow
from rehab_app.services.takes import Takes
from rehab_app.therapy.run import PlayResult, record_run, session_header
from robot_iface.build import capabilities
from robot_iface.link import MotionClient
from robot_iface.types import Certificate
from sessions.catalogue import Catalogue, TherapySession

SHORTEST_S = 1.0


class Therapy:
    """From an approved take to a sealed session.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        takes: Where takes are found.
        audit: Where verbs are noted.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue, takes: Takes, audit: Audit) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._takes = takes
        self._audit = audit

    def plan(
        self,
        take: str | Path,
        *,
        actor: Account,
        patient_id: str | None = None,
        device: str = "exoskeleton",
        mode: str = "passive",
        speed: float = 0.5,
        repetitions: int = 3,
        twin: str = "healthy",
        seed: int = 0,
        stiffness_multiple: float | None = None,
        realtime: bool = False,
    ) -> PreparedPlan:
        """Make the take playable for the patient: fitted, mirrored where needed, within limits.

        Without a patient the hand is of average size and of the take's side.

        Raises:
            Refused: The actor may not play, take or patient is unknown, the take is shorter than 1 s, or a
                value of the prescription is out of bounds.
        """
        require(actor, "play")
        row = self._takes.get(take)
        if row.duration_s < SHORTEST_S:
            raise Refused(
                f"take {row.id}",
                f"{row.duration_s:.2f} s long",
                f"{SHORTEST_S:g} s or longer",
                "record the movement again",
            )
        patient = None if patient_id is None else self._catalogue.patient(patient_id)
        order = Order(
            device=device,
            mode=mode,
            speed=speed,
            repetitions=repetitions,
            twin=twin,
            seed=seed,
            stiffness_multiple=stiffness_multiple,
            realtime=realtime,
        )
        return prepare(row, self._takes.motion(row.id), patient, order, __version__)

    def rehearse(
        self, prepared: PreparedPlan, *, actor: Account, client: MotionClient | None = None
    ) -> Certificate:
        """Dry run on the patient's virtual twin.

        Args:
            prepared: What to rehearse.
            actor: Who asks.
            client: A running motion process, None to start one for this.

        Raises:
            Refused: The actor may not, or the motion process failed.
        """
        require(actor, "play")
        if client is None:
            with MotionClient() as started:
                return self.rehearse(prepared, actor=actor, client=started)
        certificate = client.rehearse(prepared.plan)
        self._audit.note(
            actor, "rehearse", prepared.take_id, "accepted" if certificate.accepted else "not accepted"
        )
        return certificate

    def play(
        self,
        prepared: PreparedPlan,
        certificate: Certificate,
        *,
        actor: Account,
        out: Path | None = None,
        client: MotionClient | None = None,
    ) -> PlayResult:
        """Play in the motion process and seal the session; blocks until it is done or stopped.

        Args:
            prepared: What to play.
            certificate: Of its rehearsal.
            actor: Who plays.
            out: A copy for the user.
            client: A running motion process, None to start one for this.

        Raises:
            Refused: The actor may not, the take is not approved or its file was changed, the certificate was
                not given for this plan, or the motion process failed.
        """
        require(actor, "play")
        storage.check_out(out)
        row = self._takes.get(prepared.take_id)
        self.check_approved(row)
        if client is None:
            with MotionClient() as started:
                return self.play(prepared, certificate, actor=actor, out=out, client=started)
        self._audit.note(actor, "play", row.id, f"{prepared.plan.prescription.mode} {certificate.digest}")
        device = capabilities(prepared.plan.device)
        header = session_header(
            prepared.plan,
            certificate,
            prepared.geometry,
            prepared.exercise,
            prepared.patient_id or "demonstration",
            device,
        )
        client.start(prepared.plan, certificate)
        result = record_run(
            client.messages(),
            storage.new_file(self._folder.sessions),
            header,
            prepared.plan,
            prepared.geometry,
            device,
        )
        return self._keep(result, prepared, header.utc_start_ns, actor, out)

    def rehearse_and_play(
        self, prepared: PreparedPlan, *, actor: Account, out: Path | None = None
    ) -> PlayResult:
        """Rehearse, then play, in one motion process.

        Raises:
            Refused: As of ``play``, or the rehearsal met a limit.
        """
        storage.check_out(out)
        self.check_approved(self._takes.get(prepared.take_id))
        with MotionClient() as client:
            certificate = self.rehearse(prepared, actor=actor, client=client)
            check_accepted(certificate)
            return self.play(prepared, certificate, actor=actor, out=out, client=client)

    def check_approved(self, row: TakeRow) -> None:
        """Refuse a take that nobody approved, or whose file is not the approved one.

        Raises:
            Refused: It is one of these.
        """
        if row.approved_by is None:
            raise Refused(
                f"take {row.id}",
                "not approved",
                "approved by a therapist",
                f"look at it, then run rehab-app approve {row.id} --by NAME",
            )
        self._takes.check_unchanged(row)

    def _keep(
        self, result: PlayResult, prepared: PreparedPlan, utc_start_ns: int, actor: Account, out: Path | None
    ) -> PlayResult:
        """Enter the session into the catalogue and copy it where the user wants one."""
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
        if out is not None:
            storage.copy_sealed(result.path, out, result.sha256)
        return replace(result, session=entered.id, path=result.path if out is None else out)


def check_accepted(certificate: Certificate) -> None:
    """Refuse to go on with a plan whose rehearsal met a limit.

    Raises:
        Refused: The certificate is not one of acceptance.
    """
    if not certificate.accepted:
        held = "held-stretch" in certificate.summary  # playing slower would only hold the stretch for longer
        remedy = (
            "lower the stiffness, limit the range to the patient's own, or trim the still start of the take"
            if held
            else "lower the speed or the stiffness, or choose another take"
        )
        raise Refused("rehearsal", f"not passed ({certificate.summary})", "passed", remedy)
