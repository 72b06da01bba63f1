"""Who sits at the robot, as far as a plan is concerned: hand, precautions, limits, virtual twin."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from rehab_app.errors import Refused
from rehab_app.services.clinical import Clinical, bones_of
from rehab_app.services.clock import local_day
from rehab_app.services.diagnosis import needs_own_range, precautions
from rehab_app.services.limits_json import limits_to_json
from rehab_app.services.order import Order
from rehab_app.services.patient_limits import PatientLimits, TodaysLimits
from rehab_app.services.robot_limits import own_limits
from robot_iface.kinematics import HandGeometry, patient_hand
from robot_iface.types import Capabilities, Limits, Mode, PatientTwin, Plan, Side, VirtualKind
from sessions.catalogue import ClinicalRecord, Patient

_SPASTIC_KINDS = ("mas1+", "mas2", "mas3")


@dataclass(frozen=True, slots=True)
class Wearer:
    """Everything about the person that a plan needs.

    Attributes:
        patient_id: Pseudonym, "" without a patient of the clinic.
        identity: Two identifiers, side and pseudonym, for the screen only; "" without a patient.
        geometry: The hand.
        twin: The virtual patient.
        limits: Limits that hold now.
        skin_check_s: Motion time between looks at the skin, 0 for none.
        notes: What the therapist should know of the above.
    """

    patient_id: str
    identity: str
    geometry: HandGeometry
    twin: PatientTwin
    limits: Limits
    skin_check_s: float
    notes: tuple[str, ...]


class Wearers:
    """Finds out what a plan must respect.

    Args:
        clinical: Clinical records.
        limits: Limits of patients.
        clock_ns: UTC in ns.
    """

    def __init__(
        self, clinical: Clinical, limits: PatientLimits, clock_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._clinical = clinical
        self._limits = limits
        self._clock_ns = clock_ns

    def wearer(
        self,
        patient: Patient | None,
        side: Side,
        device: Capabilities,
        order: Order,
        modes: tuple[Mode, ...],
        *,
        measuring: bool = False,
    ) -> Wearer:
        """The wearer of a device now.

        Args:
            patient: The patient; None for an average healthy hand.
            side: Side of that average hand.
            device: The device.
            order: What is asked for.
            modes: Therapy modes that will be used.
            measuring: Limits are about to be measured: what was measured before does not count.

        Raises:
            Refused: A mode is locked by the diagnosis, limits do not hold any more, a real device is not
                confirmed, or nobody is named for one that is worn.
        """
        check_device(device, order, patient)
        if not device.worn:
            return self._beside(patient, side, device, order)
        if patient is None:
            return self._anybody(side, device, order)
        told = [note for mode in modes for note in self._clinical.check_mode(patient.id, mode)]
        record = self._clinical.record(patient.id)
        cautions = precautions(record)
        kind = order.named_twin(cautions.kind)
        slow = replace(cautions, spastic=cautions.spastic or kind in _SPASTIC_KINDS)
        if measuring:
            today = self._limits.shipped(device, slow, patient.id)
        else:
            today = self._limits.today(patient, device, order.wrist_rad, slow)
        self._check_own_range(patient, record, today)
        twin = PatientTwin(
            kind,
            patient.side,
            patient.hand_length_m,
            bones_m=() if record is None else bones_of(record),
            stiffness_nm_rad=cautions.stiffness_nm_rad if kind == cautions.kind else 0.0,
        )
        return Wearer(
            patient.id,
            identity_of(patient),
            patient_hand(twin),
            twin,
            today.limits,
            cautions.skin_check_s,
            (*told, *cautions.notes, *today.notes, *(_other_hand(today, kind) if device.simulated else ())),
        )

    def _check_own_range(self, patient: Patient, record: ClinicalRecord | None, today: TodaysLimits) -> None:
        """Refuse the shipped full range for a hand whose repair is young.

        Raises:
            Refused: Nobody has measured or set a range today.
        """
        young = None if record is None else needs_own_range(record, local_day(self._clock_ns()))
        if young is not None and not today.own_range:
            raise Refused(
                f"range of {patient.id}",
                f"the shipped full range, and {young.words} is young",
                "set today",
                f"set it with rehab-app limits range {patient.id} JOINT --from DEG --to DEG",
            )

    def _anybody(self, side: Side, device: Capabilities, order: Order) -> Wearer:
        """An average hand, as healthy as the virtual patient that is asked for."""
        kind = order.named_twin("healthy")
        cautions = replace(precautions(None), spastic=kind in _SPASTIC_KINDS)
        today = self._limits.shipped(device, cautions)
        twin = PatientTwin(kind, side)
        return Wearer("", "", patient_hand(twin), twin, today.limits, 0.0, today.notes)

    def _beside(self, patient: Patient | None, side: Side, device: Capabilities, order: Order) -> Wearer:
        """Nobody is inside the device: its own range and speed hold, and no lock protects anybody."""
        kind = order.named_twin("healthy")
        if patient is None:
            twin = PatientTwin(kind, side)
        else:
            twin = PatientTwin(kind, patient.side, patient.hand_length_m)
        notes = [f"The {device.name} is not worn: its own range and speed hold, not a patient's limits."]
        if order.mode != "passive":
            notes.append(
                "Nobody starts, helps or resists it: this shows the mode, it says nothing of a patient."
            )
        return Wearer(
            "" if patient is None else patient.id,
            "" if patient is None else identity_of(patient),
            patient_hand(twin),
            twin,
            own_limits(device),
            0.0,
            tuple(notes),
        )


def _other_hand(today: TodaysLimits, kind: VirtualKind) -> tuple[str, ...]:
    """What to know where a simulated hand meets limits that were measured, maybe on another one."""
    if not today.measured:
        return ()
    return (
        f"Today's limits were measured, and a virtual patient rests where its tone leaves it: if the {kind} "
        "one is refused as outside, choose the virtual patient as when they were measured, or measure again.",
    )


def identity_of(patient: Patient) -> str:
    """Name, birth date, side and pseudonym of a patient: what a person compares before anything moves."""
    name = f"{patient.given_name} {patient.family_name}".strip() or "no name"
    born = f"born {patient.birth_date}" if patient.birth_date else "birth date unknown"
    return f"{name}, {born}, {patient.side} hand ({patient.id})"


def binding(patient_id: str, plan: Plan) -> str:
    """SHA-256 that ties a plan to whom it was made for; another patient's plan has another one."""
    twin = plan.twin
    content = [
        patient_id,
        plan.device,
        plan.side,
        twin.side,
        twin.hand_length_m,
        twin.bones_m,
        plan.wrist_rad,
        limits_to_json(plan.limits),
    ]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def check_device(device: Capabilities, order: Order, patient: Patient | None) -> None:
    """Refuse a real device that nobody has confirmed by name, or that an unnamed person would wear.

    Raises:
        Refused: It is one of these, or a real device was confirmed and a simulated one is to play.
    """
    if device.simulated:
        if order.confirmed_device:
            raise Refused(
                f"device {order.device}",
                f"simulated, and {order.confirmed_device!r} was confirmed as real",
                "the device that was confirmed",
                "name the real one with --robot, or leave --confirm-device out",
            )
        return
    if order.confirmed_device != order.device:
        raise Refused(
            f"device {order.device}",
            f"confirmed as {order.confirmed_device!r}"
            if order.confirmed_device
            else "real and not confirmed",
            "confirmed by its name",
            f"look at it and the patient, then give --confirm-device {order.device}",
        )
    if not order.realtime:
        raise Refused(f"device {order.device}", "asked for in simulated time", "real time", "give --realtime")
    if not device.worn:
        return
    identified = patient is not None and patient.birth_date and (patient.given_name or patient.family_name)
    if not identified:
        raise Refused(
            "patient",
            "not identified by name and birth date",
            "identified before a worn device moves",
            "give --patient with a patient whose name and birth date are known",
        )
