"""repeatability: how much a number of this set-up changes when nothing has changed."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Annotated

import typer

from rehab_app.cli.options import By, Data, Json
from rehab_app.cli.output import Output

_SHOWN = {"rad": ("deg", 180.0 / math.pi), "m": ("mm", 1000.0), "m/s": ("mm/s", 1000.0)}


def repeatability(
    takes: Annotated[
        list[str] | None,
        typer.Argument(metavar="TAKE...", help="Repeated takes, by path or catalogue id; none to show."),
    ] = None,
    virtual: Annotated[
        int, typer.Option("--virtual", help="Record so many with the virtual camera instead.")
    ] = 0,
    exercise: Annotated[
        str, typer.Option("--exercise", help="What the virtual camera shows.")
    ] = "open_close",
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Estimate the standard error and the minimal detectable change of every number, and keep them."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.errors import Refused
    from sessions.metrics import definition

    output = Output(json)
    if takes and virtual:
        raise Refused("recordings", "takes and --virtual", "one of them", "leave one out")
    with open_clinic(data) as clinic:
        if takes:
            found = clinic.repeatability.estimate(acting(clinic, by), takes)
        elif virtual:
            found = clinic.repeatability.estimate_virtual(acting(clinic, by), virtual, exercise, output.say)
        else:
            found = clinic.repeatability.kept()
    for one in found:
        unit = definition(one.name).unit
        shown, factor = _SHOWN.get(unit, ("" if unit == "1" else unit, 1.0))
        sem, mdc = factor * one.sem, factor * one.mdc95
        words = f"SEM {sem:.3g} {shown}".rstrip() + f", MDC95 {mdc:.3g} {shown}".rstrip()
        output.say(f"{one.name} {one.subject} ({one.source}): {words}, {one.trials} measurements")
    if not found:
        output.say("Nobody has measured the repeatability of this set-up yet.")
    output.result({"repeatability": [asdict(one) for one in found]})
