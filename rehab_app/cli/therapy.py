"""Motion out: rehearse and play."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from rehab_app.cli.options import Data, Json, Out, Present, Take
from rehab_app.cli.ordering import with_order
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.order import Order
    from rehab_app.services.rows import PreparedPlan
    from rehab_app.therapy.run import PlayResult
    from robot_iface.types import Certificate

Patient: TypeAlias = Annotated[str | None, typer.Option("--patient", help="Patient id.", show_default=False)]


@with_order
def rehearse(
    take: Take, order: Order, patient: Patient = None, data: Data = None, json: Json = False
) -> None:
    """Try a take on the patient's virtual twin, without a robot."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        prepared = clinic.therapy.plan(take, order, actor=CONSOLE, patient_id=patient)
        tell_plan(output, prepared)
        certificate = clinic.therapy.rehearse(prepared, actor=CONSOLE)
    output.say(certificate.summary)
    output.result(certificate_json(prepared, certificate))
    if not certificate.accepted:
        raise typer.Exit(1)


@with_order
def play(
    take: Take,
    order: Order,
    patient: Patient = None,
    present: Present = None,
    check_fit: Annotated[bool, typer.Option("--check-fit", help="Check the fit first.")] = False,
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Rehearse an approved take and play it on the robot."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        prepared = clinic.therapy.plan(take, order, actor=CONSOLE, patient_id=patient)
        tell_plan(output, prepared)
        if check_fit:
            clinic.assessment.require_fit(patient, order, actor=CONSOLE)
            output.say("The device fits: every joint follows in the right sense.")
        result = clinic.therapy.rehearse_and_play(
            prepared, actor=CONSOLE, out=out, present=present, stoppable=_stop_on_interrupt
        )
    _tell_result(output, result)
    notes = {"speed": prepared.plan.prescription.speed, "notes": list(prepared.notes)}
    output.result({**result_json(result), **notes})
    if result.stops and not result.repetitions:  # what was begun is a session; what was not is a failure
        raise typer.Exit(1)


def _stop_on_interrupt(stop: Callable[[], None]) -> None:
    """Let the first Ctrl-C press stop, so that the run ends braked and sealed; the second breaks off."""

    def pressed(number: int, frame: object) -> None:
        del number, frame
        stop()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    signal.signal(signal.SIGINT, pressed)


def result_json(result: PlayResult) -> dict[str, Any]:
    """A session, as JSON: ``session`` is its path."""
    content = asdict(result)
    content["id"] = content.pop("session")
    content["session"] = content.pop("path")
    return content


def certificate_json(prepared: PreparedPlan, certificate: Certificate) -> dict[str, Any]:
    """A rehearsal, as JSON."""
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


def tell_plan(output: Output, prepared: PreparedPlan) -> None:
    """Who is meant, by two identifiers, and what the therapist should know."""
    if prepared.identity:
        output.say(f"For {prepared.identity}.")
    for note in prepared.notes:
        output.say(note)


def _tell_result(output: Output, result: PlayResult) -> None:
    from rehab_app.therapy.run_causes import words_of

    for item in result.repetitions:
        error = "not measurable" if item.rmse_rad is None else f"{math.degrees(item.rmse_rad):.1f} deg"
        tips = "" if item.fingertip_rmse_m is None else f", fingertips {1e3 * item.fingertip_rmse_m:.1f} mm"
        by = item.started_by or "nobody"
        output.say(f"Repetition {item.index + 1}: joint error {error}{tips}, started by {by}.")
    for stop in result.stops:
        output.say(f"Stopped after {stop.t_s:.2f} s ({stop.category}): {words_of(stop.cause)}")
    if result.stops and not result.repetitions:
        output.say("Nothing was played: no repetition was begun.")
    output.say(f"Session {result.session} lies in {result.path}.")
