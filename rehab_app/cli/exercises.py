"""The library of exercises, what is prescribed of them, and approvals that are taken back."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli.options import By, Data, Json, PatientId, Take
from rehab_app.cli.output import Output
from rehab_app.cli.people import patient
from rehab_app.cli.refusals import Commands

if TYPE_CHECKING:
    from rehab_app.services.plan_items import Plan

exercise = typer.Typer(cls=Commands, help="The library of exercises.", no_args_is_help=True)
plan = typer.Typer(cls=Commands, help="The standing prescription of a patient.", no_args_is_help=True)
patient.add_typer(plan, name="plan")


@exercise.command("list")
def list_exercises(
    words: Annotated[str, typer.Argument(metavar="WORDS", help="Words that it must hold.")] = "",
    purpose: Annotated[
        str, typer.Option("--purpose", help="opening, range, fingers, thumb, pinch, grasp, dexterity, own.")
    ] = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """List the exercises: the starter set, then the clinic's own."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        rows = clinic.exercises.list(words, purpose)
    for row in rows:
        output.say(f"{row.name}  {row.words}" + ("  (the clinic's own)" if row.own else ""))
    output.result({"exercises": [asdict(row) for row in rows]})


@exercise.command("show")
def show_exercise(
    name: Annotated[str, typer.Argument(metavar="EXERCISE", help="Its name.")],
    out: Annotated[
        Path | None, typer.Option("--out", help="Picture to make: .svg.", show_default=False)
    ] = None,
    view: Annotated[str, typer.Option("--view", help="Of the picture: palm or side.")] = "palm",
    side: Annotated[str, typer.Option("--side", help="Hand of the picture: left or right.")] = "right",
    data: Data = None,
    json: Json = False,
) -> None:
    """Show how an exercise is done; draw its beginning and its goal where asked for."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.calibration.files import check_target
    from rehab_app.services.reports import write_whole

    output = Output(json)
    if out is not None:
        check_target(out, (".svg",))
    with open_clinic(data) as clinic:
        row = clinic.exercises.get(name)
        if out is not None:
            write_whole(out, clinic.exercises.picture(row.name, view, side).encode())
    output.say(f"{row.words}: {row.purpose}")
    for number, step in enumerate(row.instructions, start=1):
        output.say(f"{number}. {step}")
    for caution in row.cautions:
        output.say(f"Take care: {caution}")
    output.result({**asdict(row), **({} if out is None else {"picture": out})})


@exercise.command("add")
def add_exercise(
    name: Annotated[str, typer.Argument(metavar="EXERCISE", help="Its name, 60 characters at most.")],
    description: Annotated[str, typer.Option("--description", help="What it is for, how it is done.")],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Add an exercise of the clinic's own, or describe it anew."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        row = clinic.exercises.add(acting(clinic, by), name, description)
    output.say(f"{row.name} is in the library.")
    output.result(asdict(row))


@plan.command("show")
def show_plan(
    patient_id: PatientId,
    versions: Annotated[int, typer.Option("--versions", help="How many versions, newest first.", min=1)] = 1,
    data: Data = None,
    json: Json = False,
) -> None:
    """Show what is prescribed for a patient, and what keeps it from being played today."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        current = clinic.plans.current(patient_id)
        notes = clinic.plans.notes(current)
        earlier = clinic.plans.history(patient_id, versions)
        words = {item.exercise: clinic.exercises.words(item.exercise) for item in current.items}
    _say_plan(output, current, words)
    for note in notes:
        output.say(note)
    output.result(
        {"plan": asdict(current), "notes": list(notes), "versions": [asdict(one) for one in earlier]}
    )


def withdraw(
    take: Take,
    reason: Annotated[str, typer.Option("--reason", help="Why; it is shown with the take.")],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Take the approval of a take back: it cannot be played any more."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        row = clinic.takes.get(take)
        said = clinic.approvals.withdraw(row.id, acting(clinic, by), reason)
    output.say(f"The approval of take {row.id} is withdrawn by {said.by}.")
    output.result({"take": row.id, "by": said.by, "reason": said.reason})


def _say_plan(output: Output, current: Plan, words: dict[str, str]) -> None:
    if not current.version:
        output.say(f"Nothing is prescribed for {current.patient}.")
        return
    output.say(
        f"Plan of {current.patient}, version {current.version} by {current.by}: {current.minutes:g} min, "
        f"{current.repetitions} repetitions, {current.sessions_per_week} sessions a week."
    )
    for number, item in enumerate(current.items, start=1):
        output.say(
            f"{number}. {words[item.exercise]} ({item.part}): {item.mode}, {item.repetitions} repetitions, "
            f"{item.minutes:g} min, hold {item.hold_s:g} s, speed {100.0 * item.speed:g} %"
        )
