"""Assessment protocols: range with extension lag, tone at three speeds, target tracking."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.services.assessment import Assessment
from rehab_app.services.order import PLAIN, Order
from rehab_app.services.plain_text import needed, one_line
from rehab_app.services.protocol_records import ENCODER, KeptResult, ProtocolRecords, where
from rehab_app.services.protocol_results import ProtocolResult, tone_notes, tones_of, tracked_of
from rehab_app.services.rows import PreparedPlan
from rehab_app.services.runs import Watch
from rehab_app.services.therapy import Therapy
from rehab_app.therapy.run import PlayResult
from robot_iface.link import MotionClient
from robot_iface.types import Certificate
from sessions.metrics import Summary

_LONGEST_POSTURE = 200


class Protocols:
    """Runs protocols and keeps their results.

    Args:
        records: Where results are kept.
        assessment: What runs guided sweeps.
        therapy: What plays takes.
        measure: Reads the numbers of a sealed session.
    """

    def __init__(
        self,
        records: ProtocolRecords,
        assessment: Assessment,
        therapy: Therapy,
        measure: Callable[[Path], Summary],
    ) -> None:
        self._records = records
        self._assessment = assessment
        self._therapy = therapy
        self._measure = measure

    def range(
        self, actor: Account, patient_id: str, order: Order = PLAIN, present: str | None = None
    ) -> KeptResult:
        """Active and passive range; today's limits follow from the same sweep.

        Raises:
            Refused: As of ``Assessment.plan_range`` and ``Assessment.measure_limits``.
        """
        assessment = self._assessment
        prepared = assessment.plan_range(patient_id, order, actor=actor)
        assessment.measure_limits(prepared, actor=actor, present=present)  # keeps the ranges itself
        return self._records.history(patient_id, "range")[0]

    def tone(
        self,
        actor: Account,
        patient_id: str,
        arm_posture: str,
        order: Order = PLAIN,
        present: str | None = None,
    ) -> KeptResult:
        """Resistance to slow, medium and fast stretches, three each. Do it before strength is tested.

        Args:
            actor: Who assesses (verb "play").
            patient_id: Pseudonym.
            arm_posture: How arm and shoulder are held, in words.
            order: Robot, wrist, virtual patient.
            present: Pseudonym of who sits at the robot, as a person confirmed.

        Raises:
            Refused: The arm posture is not stated, or as of ``Assessment``.
        """
        prepared = self.plan_tone(actor, patient_id, arm_posture, order)
        result, _ = self.run_tone(actor, prepared, arm_posture, present=present)
        if not result.tones:
            value = f"not measured (session {result.session})"
            raise Refused("tone", value, "one stretch at least", "look why it ended, and repeat it")
        return self._records.keep(actor, prepared, result)

    def plan_tone(self, actor: Account, patient_id: str, arm_posture: str, order: Order) -> PreparedPlan:
        """The stretches, planned; the arguments are those of ``tone``.

        Raises:
            Refused: As of ``tone``.
        """
        posture_told(arm_posture)
        return self._assessment.plan_tone(patient_id, order, actor=actor)

    def run_tone(
        self,
        actor: Account,
        prepared: PreparedPlan,
        arm_posture: str,
        *,
        present: str | None = None,
        client: MotionClient | None = None,
        certificate: Certificate | None = None,
        watch: Watch | None = None,
    ) -> tuple[ProtocolResult, PlayResult]:
        """Rehearse and run what ``plan_tone`` planned; ``keep`` keeps what it found.

        Args:
            actor: Who assesses (verb "play").
            prepared: The plan.
            arm_posture: How arm and shoulder are held, in words.
            present: Pseudonym of who sits at the robot, as a person confirmed.
            client: A running motion process, None to start one for this.
            certificate: Of its rehearsal, None to rehearse it here.
            watch: Told every message of the run besides.

        Returns:
            The result, without rows where no stretch was measured, and its sealed session.

        Raises:
            Refused: As of ``tone``.
        """
        told = posture_told(arm_posture)
        found = self._assessment.measure_tone(
            prepared, actor=actor, client=client, present=present, certificate=certificate, watch=watch
        )
        sweep = prepared.plan.sweep
        result = ProtocolResult(
            **where(prepared, found.run),
            protocol="tone",
            arm_posture=told,
            asked_rad_s=() if sweep is None else sweep.stretch_rad_s,
            tones=tones_of(found.result),
            notes=(ENCODER, *tone_notes(found.result)),
        )
        return result, found.run

    def keep(self, actor: Account, prepared: PreparedPlan, result: ProtocolResult) -> KeptResult:
        """Keep a result beside the sealed session that it was read from."""
        return self._records.keep(actor, prepared, result)

    def tracking(
        self,
        actor: Account,
        patient_id: str,
        take: str,
        order: Order = PLAIN,
        present: str | None = None,
    ) -> KeptResult:
        """The patient follows an approved movement alone while the device only measures.

        Raises:
            Refused: As of ``Therapy.plan`` and ``Therapy.play``.
        """
        prepared = self.plan_tracking(actor, patient_id, take, order)
        run = self._therapy.rehearse_and_play(prepared, actor=actor, present=present)
        return self.keep_tracking(actor, prepared, run)

    def plan_tracking(self, actor: Account, patient_id: str, take: str, order: Order) -> PreparedPlan:
        """The movement to follow, planned for a device that does not help.

        Raises:
            Refused: As of ``Therapy.plan``.
        """
        order = replace(order, mode="transparent")
        return self._therapy.plan(take, order, actor=actor, patient_id=patient_id)

    def keep_tracking(self, actor: Account, prepared: PreparedPlan, run: PlayResult) -> KeptResult:
        """Read how well the patient followed out of the sealed session, and keep it."""
        result = ProtocolResult(
            **where(prepared, run),
            protocol="tracking",
            tracked=tracked_of(self._measure(run.path)),
            notes=(ENCODER, "The device did not help: the error is the patient's own."),
        )
        return self._records.keep(actor, prepared, result)

    def history(self, patient_id: str, protocol: str = "") -> tuple[KeptResult, ...]:
        """Results of a patient, newest first, those of sweeps that were started elsewhere among them.

        Raises:
            Refused: The patient is unknown.
        """
        return self._records.history(patient_id, protocol)


def posture_told(text: str) -> str:
    """How arm and shoulder are held, in words; resistance means nothing without it.

    Raises:
        Refused: It is empty, too long, or holds what no screen shows.
    """
    return needed("arm posture", one_line("arm posture", text, _LONGEST_POSTURE))
