"""Motion out: rehearse and play."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from rehab_app.cli.options import Data, Json, Out, Seed, Take
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.rows import PreparedPlan
    from rehab_app.therapy.run import PlayResult
    from robot_iface.types import Certificate

Robot: TypeAlias = Annotated[str, typer.Option("--robot", help="Device.")]
Mode: TypeAlias = Annotated[str, typer.Option("--mode", help="passive or assistive.")]
Patient: TypeAlias = Annotated[str | None, typer.Option("--patient", help="Patient id.", show_default=False)]
Twin: TypeAlias = Annotated[str, typer.Option("--virtual-patient", help="Who wears the simulated robot.")]
Speed: TypeAlias = Annotated[float, typer.Option("--speed", help="Path speed, 0.1 to 1 of the therapist's.")]
Repetitions: TypeAlias = Annotated[int, typer.Option("--repetitions", help="How many times.")]
Stiffness: TypeAlias = Annotated[
    float | None,
    typer.Option("--stiffness", help="Multiple of the thesis gains, 0.1 to 10.", show_default=False),
]


def rehearse(
    take: Take,
    robot: Robot = "exoskeleton",
    mode: Mode = "passive",
    patient: Patient = None,
    virtual_patient: Twin = "healthy",
    speed: Speed = 0.5,
    repetitions: Repetitions = 3,
    stiffness: Stiffness = None,
    seed: Seed = 0,
    data: Data = None,
    json: Json = False,
) -> None:
    """Try a take on the patient's virtual twin, without a robot."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        prepared = clinic.therapy.plan(
            take,
            actor=CONSOLE,
            patient_id=patient,
            device=robot,
            mode=mode,
            speed=speed,
            repetitions=repetitions,
            twin=virtual_patient,
            seed=seed,
            stiffness_multiple=stiffness,
        )
        _tell_plan(output, prepared)
        certificate = clinic.therapy.rehearse(prepared, actor=CONSOLE)
    output.say(certificate.summary)
    output.result(_certificate_json(prepared, certificate))
    if not certificate.accepted:
        raise typer.Exit(1)


def play(
    take: Take,
    robot: Robot = "exoskeleton",
    mode: Mode = "passive",
    patient: Patient = None,
    virtual_patient: Twin = "healthy",
    speed: Speed = 0.5,
    repetitions: Repetitions = 3,
    stiffness: Stiffness = None,
    realtime: Annotated[bool, typer.Option("--realtime", help="On the wall clock.")] = False,
    seed: Seed = 0,
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Rehearse an approved take and play it on the robot."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        prepared = clinic.therapy.plan(
            take,
            actor=CONSOLE,
            patient_id=patient,
            device=robot,
            mode=mode,
            speed=speed,
            repetitions=repetitions,
            twin=virtual_patient,
            seed=seed,
            stiffness_multiple=stiffness,
            realtime=realtime,
        )
        _tell_plan(output, prepared)
        result = clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE, out=out)
    _tell_result(output, result)
    notes = {"speed": prepared.plan.prescription.speed, "notes": list(prepared.notes)}
    output.result({**result_json(result), **notes})


def result_json(result: PlayResult) -> dict[str, Any]:
    """A session, as JSON: ``session`` is its path."""
    content = asdict(result)
    content["id"] = content.pop("session")
    content["session"] = content.pop("path")
    return content


def _certificate_json(prepared: PreparedPlan, certificate: Certificate) -> dict[str, Any]:
    joints = prepared.plan.joint_names
    return {
        "accepted": certificate.accepted,
        "digest": certificate.digest,
        "summary": certificate.summary,
        "peak_interaction_nm": dict(zip(joints, certificate.peak_interaction_nm, strict=True)),
        "simulated_s": certificate.simulated_s,
        "budget_m": prepared.budget_m,
        "notes": list(prepared.notes),
    }


def _tell_plan(output: Output, prepared: PreparedPlan) -> None:
    for note in prepared.notes:
        output.say(note)


def _tell_result(output: Output, result: PlayResult) -> None:
    for item in result.repetitions:
        error = "not measurable" if item.rmse_rad is None else f"{math.degrees(item.rmse_rad):.1f} deg"
        tips = "" if item.fingertip_rmse_m is None else f", fingertips {1e3 * item.fingertip_rmse_m:.1f} mm"
        by = item.started_by or "nobody"
        output.say(f"Repetition {item.index + 1}: joint error {error}{tips}, started by {by}.")
    for stop in result.stops:
        output.say(f"Stop after {stop.t_s:.2f} s: {stop.cause} ({stop.category}).")
    output.say(f"Session {result.session} lies in {result.path}.")
