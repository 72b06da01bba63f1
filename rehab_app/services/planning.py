"""Turns an approved take and a prescription into a plan for one patient's hand on one robot."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rehab_app.errors import Refused
from rehab_app.recording.take import HandMotion
from rehab_app.services.rows import PreparedPlan, TakeRow
from rehab_app.therapy.reference import BuiltReference, build_reference
from robot_iface.build import capabilities
from robot_iface.kinematics import HandGeometry, average_hand
from robot_iface.safety import shipped_limits
from robot_iface.types import (
    MODES,
    VIRTUAL_KINDS,
    Mode,
    PatientTwin,
    Plan,
    Prescription,
    VirtualKind,
)
from sessions.catalogue import Patient

_SPASTIC = ("mas1+", "mas2", "mas3")


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What is asked for, in the words of the command line and the live page.

    Attributes:
        device: Device name.
        mode: Therapy mode.
        speed: Path speed, 0.1 to 1 of the therapist's own.
        repetitions: How many times.
        twin: Kind of the virtual patient.
        seed: Seed of everything random in the simulation.
        stiffness_multiple: Multiple of the thesis gains, None for the default.
        realtime: On the wall clock.
    """

    device: str
    mode: str
    speed: float
    repetitions: int
    twin: str
    seed: int
    stiffness_multiple: float | None
    realtime: bool


def prepare(
    row: TakeRow, motion: HandMotion, patient: Patient | None, order: Order, version: str
) -> PreparedPlan:
    """Fit the take to the patient and state everything that the motion process needs.

    Args:
        row: The take.
        motion: Its movement.
        patient: The patient, None for an average hand of the take's side.
        order: What is asked for.
        version: Software version, which the certificate covers.

    Raises:
        Refused: A word or number of the order is out of bounds, or the take is too fast for the limits.
    """
    geometry = _geometry(row, patient)
    device = capabilities(order.device)
    limits = shipped_limits(
        device.joint_names, device.q_min_rad, device.q_max_rad, spastic=order.twin in _SPASTIC
    )
    asked = _prescription(order)
    twin = PatientTwin(_kind(order.twin), geometry.side, geometry.length_m)
    built = build_reference(
        motion,
        patient_geometry=geometry,
        patient_side=geometry.side,
        driven_joints=device.joint_names,
        limits=limits,
        take_digest=row.sha256,
        speed=asked.speed,
    )
    plan = Plan(
        device=order.device,
        path=built.path,
        prescription=asked,
        limits=limits,
        twin=twin,
        seed=order.seed,
        software_version=version,
        realtime=order.realtime,
    )
    return PreparedPlan(
        plan=plan,
        budget_m=built.residual_m,
        notes=_notes(row, geometry, built),
        geometry=geometry,
        patient_id="" if patient is None else patient.id,
        take_id=row.id,
        exercise=row.exercise,
    )


def _geometry(row: TakeRow, patient: Patient | None) -> HandGeometry:
    if patient is None:
        return average_hand(side=row.side)
    return average_hand(patient.hand_length_m, patient.side)


def _prescription(order: Order) -> Prescription:
    asked = Prescription(_mode(order.mode), speed=order.speed, repetitions=order.repetitions)
    if order.stiffness_multiple is None:
        return asked
    return replace(asked, stiffness_multiple=order.stiffness_multiple)


def _mode(name: str) -> Mode:
    for mode in MODES:
        if mode == name:
            return mode
    raise Refused("mode", repr(name), "one of " + ", ".join(MODES), "choose one of them")


def _kind(name: str) -> VirtualKind:
    for kind in VIRTUAL_KINDS:
        if kind == name:
            return kind
    raise Refused("virtual patient", repr(name), "one of " + ", ".join(VIRTUAL_KINDS), "choose one of them")


def _notes(row: TakeRow, geometry: HandGeometry, built: BuiltReference) -> tuple[str, ...]:
    """What the therapist should know: mirrored, and what became of the take."""
    if geometry.side == row.side:
        return built.notes
    return (f"The take of a {row.side} hand is mirrored for a {geometry.side} hand.", *built.notes)
