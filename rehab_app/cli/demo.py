"""``demo``: the whole loop without hardware, then the clinic in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rehab_app.cli.options import Data, Json, Seed
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.walkthrough import Walk


def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Run the loop, then end.")] = False,
    serving: Annotated[bool, typer.Option("--serve", help="Open the clinic afterwards.")] = False,
    seconds: Annotated[float, typer.Option("--seconds", help="About how much therapy, s.")] = 60.0,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder of the demo's clinic.", show_default=False)
    ] = None,
    examples: Annotated[
        Path | None,
        typer.Option("--examples", help="Only make example reports of the real recordings, here."),
    ] = None,
    host: Annotated[str, typer.Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", help="Port to listen on.", min=1, max=65535)] = 8080,
    seed: Seed = 1,
    data: Data = None,
    json: Json = False,
) -> None:
    """Record, approve, rehearse, play, measure and report, all simulated."""
    from rehab_app.config import resolve_folder
    from rehab_app.services.walkthrough import check_seconds

    output = Output(json)
    check_seconds(seconds)
    folder = resolve_folder(data).root / "demo" if out is None else out
    if examples is not None:
        from rehab_app.cli.examples import make_examples

        output.result({"reports": make_examples(examples, seed, output.say)})
    elif headless and not serving:
        output.result(_headless(folder, seconds, seed, output))
    else:
        from rehab_app.cli.demo_clinic import open_demo_clinic

        open_demo_clinic(folder, host, port, seconds, seed, output)


def _headless(folder: Path, seconds: float, seed: int, output: Output) -> dict[str, Any]:
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.demo_clinic import sample_patient
    from rehab_app.config import Settings
    from rehab_app.services.walkthrough import walk

    with open_clinic(
        folder, settings=Settings()
    ) as clinic:  # a demonstration never writes into the clinic's own
        made = walk(clinic, seconds, seed, sample_patient(clinic), output.say)
    output.say(f"{made.simulated_s:.0f} s of therapy in {made.wall_s:.1f} s. Report: {made.report_html}")
    return walk_json(made)


def walk_json(made: Walk) -> dict[str, Any]:
    """The loop, as JSON: ``session`` is the last one played, ``sessions`` are both."""
    from rehab_app.cli.therapy import result_json

    return {
        "take": made.take.path,
        "session": made.sessions[-1].path,
        "report_html": made.report_html,
        "report_json": made.report_json,
        "wall_s": made.wall_s,
        "simulated_s": made.simulated_s,
        "sessions": [result_json(result) for result in made.sessions],
    }
