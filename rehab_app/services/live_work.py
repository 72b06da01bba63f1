"""What a run on the live page can be: a take played, an assessment, the fit checked."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.services.assessed import device_ends
from rehab_app.services.assessment import Assessment
from rehab_app.services.order import Order
from rehab_app.services.protocols import Protocols
from rehab_app.services.rows import PreparedPlan
from rehab_app.services.runs import Watch
from rehab_app.services.snapshot import WorkKind
from rehab_app.services.station_claims import Claims
from rehab_app.services.takes import Takes
from rehab_app.services.therapy import Therapy
from rehab_app.therapy.run import PlayResult
from rehab_app.therapy.run_causes import words_of
from robot_iface.build import capabilities
from robot_iface.link import MotionClient
from robot_iface.types import Certificate

_FITS = "The device fits: every joint follows in the right sense."


@dataclass(frozen=True, slots=True)
class Finished:
    """How a run ended.

    Attributes:
        run: Its sealed session.
        message: One sentence for the screen.
        notes: What else it found, one sentence each.
    """

    run: PlayResult
    message: str
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Work:
    """A run that is planned and can be rehearsed.

    Attributes:
        kind: What it is.
        prepared: Its plan.
        perform: Runs it in a motion process once it is rehearsed; blocks until it is sealed.
    """

    kind: WorkKind
    prepared: PreparedPlan
    perform: Callable[[Certificate, MotionClient, Watch], Finished]


class Works:
    """Plans runs in real time.

    Args:
        therapy: What plays takes.
        assessment: What measures range and fit.
        takes: Where takes are found.
        claims: Keeps a patient in therapy at one station only.
        protocols: What measures tone and target tracking.
    """

    def __init__(
        self,
        therapy: Therapy,
        assessment: Assessment,
        takes: Takes,
        claims: Claims,
        protocols: Protocols,
    ) -> None:
        self._therapy = therapy
        self._protocols = protocols
        self._assessment = assessment
        self._takes = takes
        self._claims = claims

    @property
    def trouble(self) -> str:
        """Why this station's hold on the patient was not renewed, "" where it was; the run goes on."""
        return self._claims.trouble

    def begin(self, work: Work) -> None:
        """The patient is in therapy here from now on.

        Raises:
            Refused: At another station, or the catalogue does not answer.
        """
        self._claims.start(work.prepared.patient_id)

    def end(self, work: Work) -> None:
        """Set the patient free; waits for nothing."""
        self._claims.end(work.prepared.patient_id)

    def rehearse(self, work: Work, actor: Account, client: MotionClient) -> Certificate:
        """Dry run on the virtual twin.

        Raises:
            Refused: The actor may not, or the motion process failed.
        """
        return self._therapy.rehearse(work.prepared, actor=actor, client=client)

    def plan(
        self,
        kind: str,
        actor: Account,
        patient_id: str | None,
        take_id: str,
        order: Order,
        present: str | None,
        arm_posture: str = "",
    ) -> Work:
        """A run of a kind: "therapy", "range", "fit", "tone" or "tracking".

        Args:
            kind: Which.
            actor: Who asks.
            patient_id: Pseudonym of the patient, None for a demonstration.
            take_id: What therapy plays, and what is followed in target tracking.
            order: What is asked for; it is played on the wall clock whatever it says.
            present: Pseudonym of who sits at the robot, as a person confirmed; None where nobody was asked.
            arm_posture: Tone: how arm and shoulder are held, in words.

        Raises:
            Refused: The plan cannot be made, or it is for another patient than the one who is present.
        """
        order = replace(order, realtime=True)
        if kind == "therapy":
            return self._take(actor, patient_id, take_id, order, present)
        if patient_id is None:
            raise Refused("patient", "not chosen", "one of the clinic", "choose whom to measure")
        if kind == "range":
            return self._range(actor, patient_id, order, present)
        if kind == "fit":
            return self._fit(actor, patient_id, order, present)
        if kind == "tone":
            return self._tone(actor, patient_id, arm_posture, order, present)
        if kind == "tracking":
            return self._tracking(actor, patient_id, take_id, order, present)
        raise Refused("run", repr(kind[:20]), "therapy, range, fit, tone or tracking", "choose one of these")

    def _take(
        self, actor: Account, patient_id: str | None, take_id: str, order: Order, present: str | None
    ) -> Work:
        therapy = self._therapy
        therapy.check_approved(self._takes.get(take_id))
        prepared = therapy.plan(take_id, order, actor=actor, patient_id=patient_id)
        therapy.check_patient(prepared, present)

        def perform(certificate: Certificate, client: MotionClient, watch: Watch) -> Finished:
            run = therapy.play(
                prepared, certificate, actor=actor, client=client, present=present, watch=watch
            )
            return Finished(run, _ended(run))

        return Work("therapy", prepared, perform)

    def _range(self, actor: Account, patient_id: str, order: Order, present: str | None) -> Work:
        assessment = self._assessment
        prepared = assessment.plan_range(patient_id, order, actor=actor)
        self._therapy.check_patient(prepared, present)

        def perform(certificate: Certificate, client: MotionClient, watch: Watch) -> Finished:
            found = assessment.measure_limits(
                prepared, actor=actor, client=client, present=present, certificate=certificate, watch=watch
            )
            degrees = math.degrees(found.kept.wrist_rad)
            message = f"Today's range is measured, wrist at {degrees:.0f} degrees. It holds until midnight."
            return Finished(found.run, message, device_ends(found.result))

        return Work("range", prepared, perform)

    def _fit(self, actor: Account, patient_id: str, order: Order, present: str | None) -> Work:
        assessment = self._assessment
        prepared = assessment.plan_fit(patient_id, order, actor=actor)
        self._therapy.check_patient(prepared, present)

        def perform(certificate: Certificate, client: MotionClient, watch: Watch) -> Finished:
            found = assessment.check_fit(
                prepared, actor=actor, client=client, present=present, certificate=certificate, watch=watch
            )
            verdict = found.result.verdict
            return Finished(found.run, f"It does not fit: {verdict}." if verdict else _FITS)

        return Work("fit", prepared, perform)

    def _tone(
        self, actor: Account, patient_id: str, arm_posture: str, order: Order, present: str | None
    ) -> Work:
        protocols = self._protocols
        prepared = protocols.plan_tone(actor, patient_id, arm_posture, order)
        self._therapy.check_patient(prepared, present)

        def perform(certificate: Certificate, client: MotionClient, watch: Watch) -> Finished:
            result, run = protocols.run_tone(
                actor,
                prepared,
                arm_posture,
                present=present,
                client=client,
                certificate=certificate,
                watch=watch,
            )
            if not result.tones:
                return Finished(run, _ended(run), ("The tone is not kept: no stretch was measured.",))
            protocols.keep(actor, prepared, result)
            ended = "The tone is measured and kept." if run.completed else _ended(run)
            return Finished(run, ended, result.notes)

        return Work("tone", prepared, perform)

    def _tracking(
        self, actor: Account, patient_id: str, take_id: str, order: Order, present: str | None
    ) -> Work:
        therapy, protocols = self._therapy, self._protocols
        therapy.check_approved(self._takes.get(take_id))
        prepared = protocols.plan_tracking(actor, patient_id, take_id, order)
        therapy.check_patient(prepared, present)

        def perform(certificate: Certificate, client: MotionClient, watch: Watch) -> Finished:
            run = therapy.play(
                prepared, certificate, actor=actor, client=client, present=present, watch=watch
            )
            if not run.completed:  # half a movement says nothing of how well the whole is followed
                return Finished(run, _ended(run), ("The tracking is not kept: it was not finished.",))
            kept = protocols.keep_tracking(actor, prepared, run)
            return Finished(run, "The tracking is measured and kept.", kept.result.notes)

        return Work("tracking", prepared, perform)


def first_picture(work: Work) -> dict[str, Any]:
    """Fields of the snapshot that hold for the whole of a run."""
    prepared, plan = work.prepared, work.prepared.plan
    asked, sweep = plan.prescription, plan.sweep
    return {
        "notes": prepared.notes,
        "patient_id": prepared.patient_id,
        "take_id": prepared.take_id,
        "side": prepared.geometry.side,
        "geometry": prepared.geometry,
        "repetitions": asked.repetitions if sweep is None else len(sweep.postures),
        "speed": asked.speed if sweep is None else 1.0,
        "kind": work.kind,
        "device": plan.device,
        "worn": capabilities(plan.device).worn,
        "mode": asked.mode if sweep is None else "",
    }


def _ended(run: PlayResult) -> str:
    if run.completed:
        return "The session is recorded."
    why = words_of(run.reason) if run.reason else ""
    return f"The session ended early and is recorded. {why}".strip()
