"""Target grips: ``rehab-app grasp``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli import grasp_trials
from rehab_app.cli.grasp_output import (
    path_json,
    posture_json,
    precision_json,
    tell_posture,
    tell_precision,
    tell_shape,
)
from rehab_app.cli.options import Data, Json, Side
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.grasp.hand import GraspHand


def grasp(
    thing: Annotated[
        str | None,
        typer.Option(
            "--object",
            help="cylinder:radius=R, sphere:radius=R or box:depth=D,width=W, in metres.",
            show_default=False,
        ),
    ] = None,
    hand: Annotated[
        str | None,
        typer.Option("--hand", help="dlr-hit-ii, or human:length=L in metres.", show_default=False),
    ] = None,
    grip: Annotated[
        str, typer.Option("--grip", help="transverse, diagonal, pinch, tripod or lateral.")
    ] = "transverse",
    method: Annotated[
        str, typer.Option("--method", help="contact (no link cuts the object) or thesis (tangent links).")
    ] = "contact",
    alpha_rad: Annotated[
        float | None,
        typer.Option("--alpha-rad", help="Inclination of the object; free unless given.", show_default=False),
    ] = None,
    dip_per_pip: Annotated[
        float | None,
        typer.Option(
            "--dip-per-pip",
            help="Coupling of the distal joints (robot 1, human 2/3 unless given).",
            show_default=False,
        ),
    ] = None,
    subject: Annotated[
        Path | None,
        typer.Option("--subject", help="Take that states this person's bones.", show_default=False),
    ] = None,
    side: Side = "right",
    path: Annotated[bool, typer.Option("--path", help="Give the spiral path to the posture too.")] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", help="Picture to make (.svg).", show_default=False)
    ] = None,
    shape: Annotated[
        list[Path] | None,
        typer.Option(
            "--shape", help="Take whose hand to measure; again for more repetitions.", show_default=False
        ),
    ] = None,
    take: Annotated[
        Path | None,
        typer.Option(
            "--take", help="Take to make of the path (.mcap), to approve and play.", show_default=False
        ),
    ] = None,
    reach: Annotated[
        float | None,
        typer.Option(
            "--reach",
            help="Radius of a cylinder, m, that the simulated robot hand reaches for and holds.",
            show_default=False,
        ),
    ] = None,
    reproduce: Annotated[
        Path | None,
        typer.Option(
            "--reproduce",
            help="Document (.md) of the thesis's tables and figures to make.",
            show_default=False,
        ),
    ] = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Which posture a hand should take around an object, and by which path; or what shape hands have."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.errors import Refused

    output = Output(json)
    if plot is not None and plot.suffix.lower() != ".svg":
        raise Refused("--plot", str(plot), "a file that ends in .svg", "name the picture so")
    if shape or reach is not None or reproduce is not None:
        _alone({"--object": thing, "--hand": hand, "--take": take, "--plot": None if reach else plot})
        _instead(output, shape or [], reach, plot, reproduce)
        return
    if thing is None or hand is None:
        missing = "--object" if thing is None else "--hand"
        raise Refused(missing, "missing", "stated beside the other", f"give {missing}, or --shape TAKE")
    from rehab_app.grasp.drawing import posture_svg
    from rehab_app.grasp.hand import coupled
    from rehab_app.grasp.objects import parse_object
    from rehab_app.grasp.posture import find_posture
    from rehab_app.grasp.precision import PRECISION_GRIPS
    from rehab_app.grasp.spiral import spiral_path

    grasping = _grasping(hand, side, subject)
    if grip in PRECISION_GRIPS:
        plain = not path and plot is None and take is None and alpha_rad is None and method == "contact"
        _precision(output, grasping, thing, grip, plain=plain)
        return
    if dip_per_pip is not None:
        grasping = coupled(grasping, dip_per_pip)
    posture = find_posture(grasping, parse_object(thing), grip, method, alpha_rad)
    way = spiral_path(posture) if path or take is not None else None
    made = {} if take is None or way is None else grasp_trials.write_take(output, take, posture, way)
    if plot is not None:
        from rehab_app.services.reports import write_whole

        write_whole(plot, posture_svg(posture).encode())
    tell_posture(output, posture, way)
    told = path_json(way) if path and way is not None else {}
    output.result(posture_json(posture) | told | made | {"plot": plot})


def _alone(beside: dict[str, object]) -> None:
    """Refuse what makes no sense beside --shape, --reach or --reproduce."""
    from rehab_app.errors import Refused

    for name, value in beside.items():
        if value is not None:
            raise Refused(
                "--shape, --reach or --reproduce", f"given with {name}", "given alone", "leave it out"
            )


def _instead(
    output: Output, shape: list[Path], reach: float | None, plot: Path | None, reproduce: Path | None
) -> None:
    """One of the things that this command does without --object and --hand."""
    from rehab_app.errors import Refused

    if (bool(shape), reach is not None, reproduce is not None).count(True) > 1:
        raise Refused("--shape, --reach, --reproduce", "given together", "one of them", "choose one")
    if reproduce is not None:
        grasp_trials.reproduce(output, reproduce)
    elif reach is not None:
        grasp_trials.reach(output, reach, plot)
    else:
        tell_shape(output, shape)


def _grasping(hand: str, side: str, subject: Path | None) -> GraspHand:
    """The hand that grasps."""
    from rehab_app.errors import Refused
    from rehab_app.grasp.hand import human_hand, parse_hand
    from rehab_app.recording.track_subject import subject_of
    from rehab_app.services.patients import side_named

    grasping = parse_hand(hand, side_named(side))
    if subject is None:
        return grasping
    if grasping.person is None:
        raise Refused("--subject", f"given for {grasping.name}", "given for a human hand", "use --hand human")
    return human_hand(subject_of(subject).geometry)


def _precision(output: Output, hand: GraspHand, thing: str, grip: str, *, plain: bool) -> None:
    """A grip between fingertips: no path, no picture, no inclination."""
    from rehab_app.errors import Refused
    from rehab_app.grasp.objects import parse_object
    from rehab_app.grasp.precision import find_precision

    if not plain:
        raise Refused(
            f"{grip} grip",
            "asked for with --path, --plot, --method or --alpha-rad",
            "asked for without",
            "leave them out",
        )
    held = find_precision(hand, parse_object(thing), grip)
    tell_precision(output, held)
    output.result(precision_json(held) | {"hand": hand.name, "side": hand.side})
