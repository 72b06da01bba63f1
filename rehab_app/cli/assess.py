"""Assessments: active and passive range, tone at three speeds, target tracking."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli.options import By, Confirm, Data, Json, PatientId, Present, Realtime, Robot, Seed, Twin
from rehab_app.cli.options import WristDegrees as Wrist
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.access import Account
    from rehab_app.services.clinic import Clinic
    from rehab_app.services.order import Order
    from rehab_app.services.protocol_results import JointRange, JointTone, ProtocolResult
    from rehab_app.services.protocols import KeptResult


def assess(
    patient_id: PatientId,
    kind: Annotated[str, typer.Option("--kind", help="range, tone or tracking.")] = "range",
    take: Annotated[str, typer.Option("--take", help="Tracking: the movement to follow.")] = "",
    arm_posture: Annotated[
        str, typer.Option("--arm-posture", help="Tone: how arm and shoulder are held, in words.")
    ] = "",
    robot: Robot = "exoskeleton",
    wrist_deg: Wrist = 0.0,
    virtual_patient: Twin = "",
    realtime: Realtime = False,
    confirm_device: Confirm = "",
    present: Present = None,
    seed: Seed = 0,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Assess a patient's hand by a protocol and keep the result beside the sealed session."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.services.order import Order

    output = Output(json)
    order = Order(
        device=robot,
        twin=virtual_patient,
        seed=seed,
        realtime=realtime,
        wrist_rad=math.radians(wrist_deg),
        confirmed_device=confirm_device,
    )
    with open_clinic(data) as clinic:
        kept = _run(clinic, acting(clinic, by), patient_id, kind, (take, arm_posture), order, present)
    _tell(output, kept.result)
    output.result({"patient": patient_id, "id": kept.id, "by": kept.by, **asdict(kept.result)})


def _run(
    clinic: Clinic,
    actor: Account,
    patient_id: str,
    kind: str,
    asked: tuple[str, str],
    order: Order,
    present: str | None,
) -> KeptResult:
    from rehab_app.errors import Refused
    from rehab_app.services.protocol_results import PROTOCOLS

    take, arm_posture = asked
    protocols = clinic.protocols
    if kind == "range":
        return protocols.range(actor, patient_id, order, present)
    if kind == "tone":
        return protocols.tone(actor, patient_id, arm_posture, order, present)
    if kind == "tracking":
        if not take:
            raise Refused("take", "not named", "an approved take to follow", "name it with --take")
        return protocols.tracking(actor, patient_id, take, order, present)
    raise Refused("assessment", repr(kind[:40]), "one of " + ", ".join(PROTOCOLS), "choose one of them")


def _tell(output: Output, result: ProtocolResult) -> None:
    for row in result.ranges:
        output.say(_range_words(row))
    for tone in result.tones:
        output.say(_tone_words(tone))
    for one in result.tracked:
        if one.value is not None and one.subject == "whole":
            output.say(f"{one.name}: {one.value:.4g} {one.unit}")
    for note in result.notes:
        output.say(note)


def _range_words(row: JointRange) -> str:
    low, high = _degrees(row.passive_min_rad), _degrees(row.passive_max_rad)
    more = ", device limit" if row.max_at_device_end else ""
    words = f"{row.joint}: alone {_degrees(row.active_min_rad)} to {_degrees(row.active_max_rad)}"
    lag = f"extension lag {_degrees(row.extension_lag_rad)}, deficit {_degrees(row.extension_deficit_rad)}"
    return f"{words}, led {low} to {'>= ' if more else ''}{high} degrees{more}; {lag} degrees."


def _tone_words(tone: JointTone) -> str:
    if tone.per_speed_nms_rad is None or tone.interval_nms_rad is None:
        return f"{tone.joint}: speeds too alike to tell."
    low, high = tone.interval_nms_rad
    rises = f"{tone.per_speed_nms_rad:.4f} Nm per rad/s (95 % {low:.4f} to {high:.4f})"
    return f"{tone.joint}: resistance rises by {rises} with speed."


def _degrees(angle_rad: float | None) -> str:
    return "not measured" if angle_rad is None else f"{math.degrees(angle_rad):.0f}"
