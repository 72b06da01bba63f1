"""Therapy: fit a take to a patient, rehearse, play."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from rehab_app import __version__
from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.clinical import Clinical
from rehab_app.services.order import PLAIN, Order
from rehab_app.services.planning import Planner
from rehab_app.services.rows import PreparedPlan, TakeRow
from rehab_app.services.runs import Runs, Watch
from rehab_app.services.takes import Takes
from rehab_app.services.wearer import binding
from rehab_app.therapy.run import PlayResult
from robot_iface.build import capabilities
from robot_iface.link import MotionClient
from robot_iface.types import Certificate
from sessions.catalogue import Catalogue

SHORTEST_S = 1.0


class Therapy:
    """From an approved take to a sealed session.

    Args:
        catalogue: The clinic's catalogue.
        takes: Where takes are found.
        clinical: Clinical records.
        planner: Makes plans.
        runs: Runs and keeps them.
        audit: Where verbs are noted.
        clock_ns: UTC in ns.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        takes: Takes,
        clinical: Clinical,
        planner: Planner,
        runs: Runs,
        audit: Audit,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._catalogue = catalogue
        self._takes = takes
        self._clinical = clinical
        self._planner = planner
        self._runs = runs
        self._audit = audit
        self._clock_ns = clock_ns

    def plan(
        self, take: str | Path, order: Order = PLAIN, *, actor: Account, patient_id: str | None = None
    ) -> PreparedPlan:
        """Make the take playable for the patient: fitted, mirrored where needed, within limits.

        Without a patient the hand is of average size and of the take's side.

        Args:
            take: Path or catalogue id.
            order: What is asked for.
            actor: Who asks.
            patient_id: Pseudonym of the patient.

        Raises:
            Refused: The actor may not play, take or patient is unknown, the take is shorter than 1 s, the
                patient's diagnosis locks the mode, limits do not hold any more, or a value is out of bounds.
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
        self._takes.check_unchanged(row)
        patient = None if patient_id is None else self._catalogue.patient(patient_id)
        return self._planner.prepare(row, self._takes.motion(row.id), patient, order, __version__)

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
        subject = prepared.take_id or prepared.patient_id
        self._audit.note(actor, "rehearse", subject, "accepted" if certificate.accepted else "not accepted")
        return certificate

    def play(
        self,
        prepared: PreparedPlan,
        certificate: Certificate,
        *,
        actor: Account,
        out: Path | None = None,
        client: MotionClient | None = None,
        present: str | None = None,
        watch: Watch | None = None,
    ) -> PlayResult:
        """Play in the motion process and seal the session; blocks until it is done or stopped.

        Args:
            prepared: What to play.
            certificate: Of its rehearsal.
            actor: Who plays.
            out: A copy for the user.
            client: A running motion process, None to start one for this.
            present: Pseudonym of who sits at the robot, as a person confirmed; None where nobody was asked.
            watch: Told every message of the run besides.

        Raises:
            Refused: The actor may not, the take is not approved or its file was changed, the plan is
                another patient's or does not hold any more, the certificate was not given for it, or the
                motion process failed.
        """
        require(actor, "play")
        storage.check_out(out)
        self.check_approved(self._takes.get(prepared.take_id))
        self.check_patient(prepared, present)
        if client is None:
            with MotionClient() as started:
                return self.play(
                    prepared, certificate, actor=actor, out=out, client=started, present=present, watch=watch
                )
        self._runs.order(prepared, actor)
        return self._runs.run(client, prepared, certificate, actor, out, watch)

    def rehearse_and_play(
        self,
        prepared: PreparedPlan,
        *,
        actor: Account,
        out: Path | None = None,
        present: str | None = None,
        stoppable: Callable[[Callable[[], None]], None] = lambda stop: None,
    ) -> PlayResult:
        """Rehearse, then play, in one motion process.

        Args:
            prepared: What is played.
            actor: Who plays.
            out: A copy for the user.
            present: Pseudonym of who sits at the robot, as a person confirmed; None where nobody was asked.
            stoppable: Called once with what presses stop, which may then be called from anywhere.

        Raises:
            Refused: As of ``play``, or the rehearsal met a limit.
        """
        storage.check_out(out)
        self.check_approved(self._takes.get(prepared.take_id))
        self.check_patient(prepared, present)
        with MotionClient() as client:
            stoppable(client.press_stop)
            certificate = self.rehearse(prepared, actor=actor, client=client)
            check_accepted(certificate)
            return self.play(prepared, certificate, actor=actor, out=out, client=client, present=present)

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

    def check_patient(self, prepared: PreparedPlan, present: str | None = None) -> None:
        """Refuse a plan for anybody but the patient it was made for, or one that time has overtaken.

        Raises:
            Refused: The plan was made for another patient or changed since, the patient's side or hand was
                corrected meanwhile, the mode was locked meanwhile, or its limits have expired.
        """
        again = "plan it again for this patient"
        if prepared.binding != binding(prepared.patient_id, prepared.plan):
            raise Refused("plan", "made for another patient, or changed since", "as it was made", again)
        if present is not None and present != prepared.patient_id:
            made_for = prepared.patient_id or "no patient of the clinic"
            raise Refused("plan", f"made for {made_for}", f"made for {present}, who is present", again)
        if not prepared.patient_id:
            return
        patient, twin = self._catalogue.patient(prepared.patient_id), prepared.plan.twin
        if (patient.side, patient.hand_length_m) != (twin.side, twin.hand_length_m):
            met = f"for a {twin.side} hand of {100 * twin.hand_length_m:.1f} cm"
            bound = f"for the {patient.side} hand of {100 * patient.hand_length_m:.1f} cm on record"
            raise Refused(f"plan of {patient.id}", met, bound, again)
        if capabilities(prepared.plan.device).worn:  # a lock protects a hand inside the robot, nobody else
            self._clinical.check_mode(patient.id, prepared.plan.prescription.mode)
        expires = prepared.plan.limits.expires_utc_ns
        if expires and self._clock_ns() >= expires:
            again = "measure them again with rehab-app limits measure"
            raise Refused(f"limits of {patient.id}", "expired", "measured today", again)


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
