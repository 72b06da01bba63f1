"""Limits of patients: look, raise a torque, set a range."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from rehab_app.cli.options import (
    By,
    Confirm,
    Data,
    Json,
    Out,
    PatientId,
    Present,
    Realtime,
    Robot,
    Seed,
    Twin,
    WristDegrees,
)
from rehab_app.cli.output import Output
from rehab_app.cli.refusals import Commands

if TYPE_CHECKING:
    from rehab_app.services.order import Order
    from rehab_app.services.patient_limits import TodaysLimits
    from robot_iface.types import Float64

limits = typer.Typer(cls=Commands, help="What a patient's joints may be asked today.", no_args_is_help=True)
Joint: TypeAlias = Annotated[str, typer.Argument(metavar="JOINT", help="Driven joint, such as index_pip.")]
Since: TypeAlias = Annotated[
    int | None,
    typer.Option("--since", help="Version of the limits that you read; another one now is refused."),
]
Reason: TypeAlias = Annotated[str, typer.Option("--reason", help="Why; needed to allow more than holds.")]


@limits.command("show")
def show(
    patient_id: PatientId,
    robot: Robot = "exoskeleton",
    wrist_deg: WristDegrees = 0.0,
    data: Data = None,
    json: Json = False,
) -> None:
    """Show the limits that hold now and where they come from."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        today = clinic.limits.show(patient_id, robot, math.radians(wrist_deg))
    output.result(tell_limits(output, patient_id, robot, today))


@limits.command("raise")
def raise_(
    patient_id: PatientId,
    joint: Joint,
    tau_nm: Annotated[float, typer.Option("--nm", help="Torque between hand and device, at most 0.45 Nm.")],
    reason: Reason = "",
    robot: Robot = "exoskeleton",
    wrist_deg: WristDegrees = 0.0,
    since: Since = None,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Set a joint's torque limit: more, for today, by a therapist; less, until it is set anew, by anyone."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        today = clinic.limits.set_torque(
            acting(clinic, by),
            patient_id,
            joint,
            tau_nm,
            reason=reason,
            device=robot,
            wrist_rad=math.radians(wrist_deg),
            since=since,
        )
    output.result(tell_limits(output, patient_id, robot, today))


@limits.command("range")
def range_(
    patient_id: PatientId,
    joint: Joint,
    low_deg: Annotated[float, typer.Option("--from", help="Least flexion, degrees.")],
    high_deg: Annotated[float, typer.Option("--to", help="Greatest flexion, degrees.")],
    reason: Reason = "",
    robot: Robot = "exoskeleton",
    wrist_deg: WristDegrees = 0.0,
    since: Since = None,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Set a joint's range within what was measured or ships: narrower by anyone, wider by a therapist."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        today = clinic.limits.set_range(
            acting(clinic, by),
            patient_id,
            joint,
            math.radians(low_deg),
            math.radians(high_deg),
            reason=reason,
            device=robot,
            wrist_rad=math.radians(wrist_deg),
            since=since,
        )
    output.result(tell_limits(output, patient_id, robot, today))


@limits.command("measure")
def measure(
    patient_id: PatientId,
    robot: Robot = "exoskeleton",
    wrist_deg: WristDegrees = 0.0,
    virtual_patient: Twin = "",
    realtime: Realtime = False,
    confirm_device: Confirm = "",
    present: Present = None,
    seed: Seed = 0,
    by: By = "",
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Measure today's range in a guided sweep (open, tabletop, hook, fist) and keep it until the day ends."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.cli.therapy import result_json, tell_plan
    from rehab_app.services.assessed import device_ends

    output = Output(json)
    order = _order(robot, wrist_deg, virtual_patient, realtime, confirm_device, seed)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        prepared = clinic.assessment.plan_range(patient_id, order, actor=actor)
        tell_plan(output, prepared)
        measured = clinic.assessment.measure_limits(prepared, actor=actor, out=out, present=present)
        today = clinic.limits.show(patient_id, robot, order.wrist_rad)
    ends = device_ends(measured.result)
    for sentence in ends:
        output.say(sentence)
    said = tell_limits(output, patient_id, robot, today)
    output.result({**said, "device_ends": list(ends), "run": result_json(measured.run)})


@limits.command("fit")
def fit(
    patient_id: PatientId,
    robot: Robot = "exoskeleton",
    wrist_deg: WristDegrees = 0.0,
    virtual_patient: Twin = "",
    realtime: Realtime = False,
    confirm_device: Confirm = "",
    present: Present = None,
    seed: Seed = 0,
    by: By = "",
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Check fit and signs after donning with small slow movements; exit 1 where the device does not fit."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.cli.therapy import result_json, tell_plan

    output = Output(json)
    order = _order(robot, wrist_deg, virtual_patient, realtime, confirm_device, seed)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        prepared = clinic.assessment.plan_fit(patient_id, order, actor=actor)
        tell_plan(output, prepared)
        checked = clinic.assessment.check_fit(prepared, actor=actor, out=out, present=present)
    found = checked.result
    output.say(found.verdict or "The device fits: every joint follows in the right sense.")
    output.result(
        {
            "patient": patient_id,
            "fits": not found.verdict,
            "verdict": found.verdict,
            "gain": _by_joint(found.joint_names, found.gain),
            "stiffness_nm_rad": _by_joint(found.joint_names, found.stiffness_nm_rad),
            "sticking_nm": _by_joint(found.joint_names, found.sticking_nm),
            "neutral_rad": _by_joint(found.joint_names, found.neutral_rad),
            "run": result_json(checked.run),
        }
    )
    if found.verdict:
        raise typer.Exit(1)


def _order(
    robot: str, wrist_deg: float, virtual_patient: str, realtime: bool, confirm_device: str, seed: int
) -> Order:
    from rehab_app.services.order import Order

    return Order(
        device=robot,
        twin=virtual_patient,
        realtime=realtime,
        wrist_rad=math.radians(wrist_deg),
        confirmed_device=confirm_device,
        seed=seed,
    )


def _by_joint(names: tuple[str, ...], values: Float64) -> dict[str, float | None]:
    """Values by joint; null for what was not measured."""
    return {
        name: value if math.isfinite(value) else None
        for name, value in zip(names, values.tolist(), strict=True)
    }


def tell_limits(output: Output, patient_id: str, robot: str, today: TodaysLimits) -> dict[str, Any]:
    """Tell a person the limits joint by joint in degrees; returns them in SI units, as JSON."""
    from robot_iface.build import capabilities

    held, names = today.limits, capabilities(robot).joint_names
    columns: dict[str, dict[str, float]] = {}
    for index, name in enumerate(names):
        row = {
            "q_min_rad": float(held.q_min_rad[index]),
            "q_max_rad": float(held.q_max_rad[index]),
            "flexion_speed_rad_s": float(held.flexion_speed_rad_s[index]),
            "extension_speed_rad_s": float(held.extension_speed_rad_s[index]),
            "tau_interaction_nm": float(held.tau_interaction_nm[index]),
        }
        columns[name] = row
        output.say(
            f"{name}: {math.degrees(row['q_min_rad']):.0f} to {math.degrees(row['q_max_rad']):.0f} degrees, "
            f"{row['tau_interaction_nm']:.3g} Nm"
        )
    for note in today.notes:
        output.say(note)
    return _limits_json(patient_id, robot, today, columns)


def _limits_json(
    patient_id: str, robot: str, today: TodaysLimits, columns: dict[str, dict[str, float]]
) -> dict[str, Any]:
    held = today.limits
    return {
        "patient": patient_id,
        "robot": robot,
        "version": today.version,
        "measured": today.measured,
        "measured_utc_ns": held.measured_utc_ns or None,
        "expires_utc_ns": held.expires_utc_ns or None,
        "wrist_rad": None if math.isnan(held.wrist_rad) else held.wrist_rad,
        "joints": columns,
        "hulls": [{"joints": hull.joints, "corners_rad": hull.corners_rad.tolist()} for hull in held.hulls],
        "notes": list(today.notes),
    }
