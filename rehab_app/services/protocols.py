"""Assessment protocols: range with extension lag, tone at three speeds, target tracking."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.services.assessment import Assessment
from rehab_app.services.order import PLAIN, Order
from rehab_app.services.protocol_records import ENCODER, KeptResult, ProtocolRecords, where
from rehab_app.services.protocol_results import ProtocolResult, tone_notes, tones_of, tracked_of
from rehab_app.services.therapy import Therapy
from sessions.metrics import Summary

_LONGEST = 200


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
        if not 1 <= len(arm_posture.strip()) <= _LONGEST:
            length = f"{len(arm_posture.strip())} characters long"
            raise Refused(
                "arm posture", length, f"1 to {_LONGEST} characters", "say how arm and shoulder are held"
            )
        assessment = self._assessment
        prepared = assessment.plan_tone(patient_id, order, actor=actor)
        found = assessment.measure_tone(prepared, actor=actor, present=present)
        sweep = prepared.plan.sweep
        result = ProtocolResult(
            **where(prepared, found.run),
            protocol="tone",
            arm_posture=arm_posture.strip(),
            asked_rad_s=() if sweep is None else sweep.stretch_rad_s,
            tones=tones_of(found.result),
            notes=(ENCODER, *tone_notes(found.result)),
        )
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
        order = replace(order, mode="transparent")
        therapy = self._therapy
        prepared = therapy.plan(take, order, actor=actor, patient_id=patient_id)
        run = therapy.rehearse_and_play(prepared, actor=actor, present=present)
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
