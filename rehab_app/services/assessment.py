"""Guided assessments: the sweep that measures today's limits, and the fit check after donning."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from rehab_app import __version__
from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.assessed import (
    CheckedFit,
    Heard,
    MeasuredLimits,
    ToneRun,
    fit_to_json,
    neutral_from_json,
)
from rehab_app.services.clinical import Clinical
from rehab_app.services.clock import day_end_ns
from rehab_app.services.order import PLAIN, Order
from rehab_app.services.patient_limits import PatientLimits
from rehab_app.services.protocol_records import ProtocolRecords
from rehab_app.services.rows import PreparedPlan
from rehab_app.services.runs import Runs, Watch
from rehab_app.services.sweep_postures import EXERCISES, sweep_of
from rehab_app.services.therapy import Therapy, check_accepted
from rehab_app.services.wearer import Wearers, binding
from rehab_app.therapy.run import PlayResult
from robot_iface.build import capabilities
from robot_iface.link import MotionClient
from robot_iface.motion.limits import limits_of
from robot_iface.runtime import Message
from robot_iface.runtime.sweep_fit_reading import fit_result
from robot_iface.runtime.sweep_reading import measured_range
from robot_iface.runtime.sweep_tone_reading import tone_result
from robot_iface.types import (
    MODES,
    Certificate,
    Float64,
    Mode,
    Plan,
    Prescription,
    RunEnd,
    Sweep,
)
from sessions.catalogue import Catalogue, FitCheck


class Assessment:
    """Runs guided assessments and keeps what they measure.

    Args:
        catalogue: The clinic's catalogue.
        clinical: Clinical records.
        wearers: What a plan must respect of a patient.
        limits: Where limits are kept.
        therapy: What rehearses.
        runs: Runs and keeps them.
        records: Where ranges are kept.
        clock_ns: UTC in ns.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        clinical: Clinical,
        wearers: Wearers,
        limits: PatientLimits,
        therapy: Therapy,
        runs: Runs,
        records: ProtocolRecords,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._catalogue = catalogue
        self._clinical = clinical
        self._wearers = wearers
        self._limits = limits
        self._therapy = therapy
        self._runs = runs
        self._records = records
        self._clock_ns = clock_ns

    def plan_range(self, patient_id: str, order: Order = PLAIN, *, actor: Account) -> PreparedPlan:
        """The sweep through open, tabletop, hook and fist, alone first, then gently led.

        Raises:
            Refused: The actor may not play, the patient is unknown, or the diagnosis locks passive or active
                motion today.
        """
        return self._plan(patient_id, order, actor, "range", ("passive", "transparent"))

    def plan_fit(self, patient_id: str, order: Order = PLAIN, *, actor: Account) -> PreparedPlan:
        """The small slow movements that check fit and signs after donning.

        Raises:
            Refused: The actor may not play, the patient is unknown, or the diagnosis locks every mode today.
        """
        locked = self._clinical.locks(patient_id)
        opened: tuple[Mode, ...] = tuple(mode for mode in MODES if mode not in locked)
        return self._plan(patient_id, order, actor, "fit", opened[:1] or MODES[:1])

    def plan_tone(self, patient_id: str, order: Order = PLAIN, *, actor: Account) -> PreparedPlan:
        """The stretches of the fingers at three speeds, three times each.

        Raises:
            Refused: The actor may not play, the patient is unknown, or the diagnosis locks passive today.
        """
        return self._plan(patient_id, order, actor, "tone", ("passive",))

    def measure_limits(
        self,
        prepared: PreparedPlan,
        *,
        actor: Account,
        out: Path | None = None,
        client: MotionClient | None = None,
        present: str | None = None,
        certificate: Certificate | None = None,
        watch: Watch | None = None,
    ) -> MeasuredLimits:
        """Rehearse and run the sweep, and keep its limits for the rest of the day.

        Args:
            prepared: What ``plan_range`` planned.
            actor: Who measures.
            out: A copy of the session for the user.
            client: A running motion process, None to start one for this.
            present: Pseudonym of who sits at the robot, as a person confirmed.
            certificate: Of its rehearsal, None to rehearse it here.
            watch: Told every message of the run besides.

        Raises:
            Refused: The actor may not, the plan is another patient's, the rehearsal met a limit, or the sweep
                was broken off or measured nothing that can be used.
        """
        run, heard = self._run(prepared, actor, out, client, present, certificate, watch)
        sweep, device = _sweep(prepared), capabilities(prepared.plan.device)
        result = measured_range(heard.blocks, heard.phases, sweep, prepared.plan.limits, device)
        now_ns = self._clock_ns()
        limits = limits_of(
            result,
            prepared.plan.limits,
            measured_utc_ns=now_ns,
            expires_utc_ns=day_end_ns(now_ns),
            wrist_rad=prepared.plan.wrist_rad,
        )
        patient = self._catalogue.patient(prepared.patient_id)
        kept = self._limits.keep(actor, patient, device, limits, prepared.plan.wrist_rad)
        self._records.keep_range(actor, prepared, run, result)
        return MeasuredLimits(run, result, kept)

    def check_fit(
        self,
        prepared: PreparedPlan,
        *,
        actor: Account,
        out: Path | None = None,
        client: MotionClient | None = None,
        present: str | None = None,
        certificate: Certificate | None = None,
        watch: Watch | None = None,
    ) -> CheckedFit:
        """Rehearse and run the fit check; a device that does not fit is a finding, not an error.

        The arguments are those of ``measure_limits``.

        Raises:
            Refused: The actor may not, the plan is another patient's, or the rehearsal met a limit.
        """
        usual = self._usual_neutral(prepared)  # before it runs: afterwards nobody may answer
        run, heard = self._run(prepared, actor, out, client, present, certificate, watch)
        sweep, recorded = _sweep(prepared), prepared.plan.twin.stiffness_nm_rad
        result = fit_result(heard.blocks, heard.phases, heard.end, sweep, recorded, usual)
        self._catalogue.add_fit_check(
            FitCheck(
                patient=prepared.patient_id,
                side=prepared.plan.side,
                device=prepared.plan.device,
                content=fit_to_json(result),
                verdict=result.verdict,
                session=run.session,
                by=actor.name,
            )
        )
        return CheckedFit(run, result)

    def measure_tone(
        self,
        prepared: PreparedPlan,
        *,
        actor: Account,
        out: Path | None = None,
        client: MotionClient | None = None,
        present: str | None = None,
        certificate: Certificate | None = None,
        watch: Watch | None = None,
    ) -> ToneRun:
        """Rehearse and run the tone test. The arguments are those of ``measure_limits``.

        Raises:
            Refused: The actor may not, the plan is another patient's, or the rehearsal met a limit.
        """
        run, heard = self._run(prepared, actor, out, client, present, certificate, watch)
        return ToneRun(run, tone_result(heard.blocks, heard.phases, _sweep(prepared)))

    def require_fit(self, patient_id: str | None, order: Order, *, actor: Account) -> CheckedFit:
        """The fit check before a worn run, for whoever asks for it.

        Raises:
            Refused: Nobody is named, or the device does not fit; also as of ``plan_fit`` and ``check_fit``.
        """
        if patient_id is None:
            raise Refused("fit check", "of nobody", "of a patient", "name the patient with --patient")
        checked = self.check_fit(self.plan_fit(patient_id, order, actor=actor), actor=actor)
        if checked.result.verdict:
            remedy = "don the device again and repeat the check"
            raise Refused("fit", f"not good ({checked.result.verdict})", "good at every joint", remedy)
        return checked

    def _usual_neutral(self, prepared: PreparedPlan) -> Float64 | None:
        """Neutral posture at the last good fit check of this hand in this device, (J,); None before one."""
        for row in self._catalogue.fit_checks(prepared.patient_id, prepared.plan.device):
            if not row.verdict and row.side == prepared.plan.side:
                return neutral_from_json(row.content, prepared.plan.joint_names)
        return None

    def _plan(
        self, patient_id: str, order: Order, actor: Account, kind: str, modes: tuple[Mode, ...]
    ) -> PreparedPlan:
        require(actor, "play")
        patient = self._catalogue.patient(patient_id)
        device = capabilities(order.device)
        if not device.worn:
            raise Refused(f"{order.device}", "not worn", "worn by the patient", "choose another robot")
        wearer = self._wearers.wearer(patient, patient.side, device, order, modes, measuring=True)
        sweep = sweep_of(kind, device, patient.side, wearer.limits)
        plan = Plan(
            device=order.device,
            path=None,
            prescription=Prescription("transparent", skin_check_s=wearer.skin_check_s),
            limits=wearer.limits,
            twin=wearer.twin,
            seed=order.seed,
            software_version=__version__,
            realtime=order.realtime,
            sweep=sweep,
            wrist_rad=order.wrist_rad,
            confirmed_device=order.confirmed_device,
        )
        return PreparedPlan(
            plan=plan,
            budget_m={},
            notes=wearer.notes,
            geometry=wearer.geometry,
            patient_id=patient.id,
            take_id="",
            exercise=EXERCISES[kind],
            identity=wearer.identity,
            binding=binding(patient.id, plan),
        )

    def _run(
        self,
        prepared: PreparedPlan,
        actor: Account,
        out: Path | None,
        client: MotionClient | None,
        present: str | None,
        certificate: Certificate | None,
        watch: Watch | None,
    ) -> tuple[PlayResult, Heard]:
        """Rehearse, run, seal; what was measured besides."""
        require(actor, "play")
        storage.check_out(out)
        self._therapy.check_patient(prepared, present)
        if client is None:
            with MotionClient() as started:
                return self._run(prepared, actor, out, started, present, certificate, watch)
        if certificate is None:
            certificate = self._therapy.rehearse(prepared, actor=actor, client=client)
        check_accepted(certificate)
        heard = Heard()

        def hear(message: Message | RunEnd) -> None:
            heard.take(message)
            if watch is not None:
                watch(message)

        run = self._runs.run(client, prepared, certificate, actor, out, hear)
        return run, heard


def _sweep(prepared: PreparedPlan) -> Sweep:
    sweep = prepared.plan.sweep
    if sweep is None:
        raise Refused("assessment", "a plan that plays a take", "a guided sweep", "plan an assessment")
    return sweep
