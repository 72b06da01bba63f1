"""Target grips: ``rehab-app grasp``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rehab_app.cli.options import Data, Json, Side
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.grasp.hand import GraspHand
    from rehab_app.grasp.posture import Posture
    from rehab_app.grasp.precision import PrecisionGrip
    from rehab_app.grasp.spiral import GraspPath

_DEG = 180.0 / math.pi


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
    data: Data = None,
    json: Json = False,
) -> None:
    """Which posture a hand should take around an object, and by which path; or what shape hands have."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.errors import Refused

    output = Output(json)
    if shape:
        if thing is not None or hand is not None:
            raise Refused("--shape", "given with --object or --hand", "given alone", "leave them out")
        _tell_shape(output, shape)
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

    if plot is not None and plot.suffix.lower() != ".svg":
        raise Refused("--plot", str(plot), "a file that ends in .svg", "name the picture so")
    grasping = _grasping(hand, side, subject)
    if grip in PRECISION_GRIPS:
        plain = not path and plot is None and alpha_rad is None and method == "contact"
        _precision(output, grasping, thing, grip, plain=plain)
        return
    if dip_per_pip is not None:
        grasping = coupled(grasping, dip_per_pip)
    posture = find_posture(grasping, parse_object(thing), grip, method, alpha_rad)
    way = spiral_path(posture) if path else None
    if plot is not None:
        plot.write_text(posture_svg(posture), encoding="utf-8")
    _tell(output, posture, way)
    output.result(posture_json(posture) | ({} if way is None else path_json(way)) | {"plot": plot})


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
    _tell_precision(output, held)
    output.result(precision_json(held) | {"hand": hand.name, "side": hand.side})


def posture_json(posture: Posture) -> dict[str, Any]:
    """The posture as JSON, SI units; a radius that is infinite (a straight digit) is null."""
    return {
        "hand": posture.hand.name,
        "side": posture.hand.side,
        "grip": posture.grip,
        "method": posture.method,
        "z_m": posture.z_m,
        "alpha_rad": posture.alpha_rad,
        "objective_m": posture.objective_m,
        "angles_rad": posture.angles_rad,
        "radius_m": {
            digit: {joint: value if math.isfinite(value) else None for joint, value in radii.items()}
            for digit, radii in posture.radius_m.items()
        },
        "contacts": [{"digit": at.digit, "link": at.link, "gap_m": at.gap_m} for at in posture.contacts],
        "penetration_m": posture.penetration_m,
        "arc_rad": posture.arc_rad,
        "aperture_rad": posture.aperture_rad,
        "warnings": list(posture.warnings),
    }


def precision_json(held: PrecisionGrip) -> dict[str, Any]:
    """A pinch, tripod or lateral grip as JSON, SI units; the centre is in the right-hand palm frame."""
    return {
        "grip": held.grip,
        "method": "contact",
        "angles_rad": held.angles_rad,
        "centre_m": held.centre_m.tolist(),
        "contacts": [{"digit": digit, "link": "pad", "gap_m": gap} for digit, gap in held.gap_m.items()],
        "penetration_m": max(0.0, *(-gap for gap in held.gap_m.values())),
        "opposition_rad": held.opposition_rad,
        "warnings": list(held.warnings),
    }


def path_json(way: GraspPath) -> dict[str, Any]:
    """The way to the posture as JSON: joints by name over the path coordinate."""
    from sessions.records import JOINTS

    columns = {name: way.joints_rad[:, index].tolist() for index, name in enumerate(JOINTS)}
    return {
        "path": {
            "s": way.s.tolist(),
            "joints_rad": columns,
            "start_pip_rad": way.start_pip_rad,
            "warnings": list(way.warnings),
        }
    }


def _tell_shape(output: Output, takes: list[Path]) -> None:
    from rehab_app.grasp.shape_take import shape_json, shape_of_takes

    found = shape_of_takes(takes)
    measured = shape_json(found)
    output.say(f"{measured['repetitions']} closed hands, mean +- standard deviation")
    output.say(f"  aperture {_spoken(measured['aperture_rad'], _DEG)} deg")
    for digit, radii in measured["radius_m"].items():
        curved = ", ".join(f"{joint} {_spoken(entry, 1e3)} mm" for joint, entry in radii.items())
        output.say(f"  {digit}: radius {curved}")
    for pair, entry in measured["abduction_rad"].items():
        apart = _spoken(measured["pip_distance_m"][pair], 1e3)
        output.say(
            f"  {pair.replace('_', ' and ')}: {_spoken(entry, _DEG)} deg, middle joints {apart} mm apart"
        )
    parts = measured["opposition_rad"]
    output.say(
        f"  thumb opposition {_spoken(parts['in_plane'], _DEG)} deg around the palm's axis, "
        f"{_spoken(parts['from_axis'], _DEG)} deg from it"
    )
    output.result(measured)


def _spoken(entry: dict[str, Any], factor: float) -> str:
    if entry["mean"] is None:
        return "unknown"
    spread = "" if entry["sd"] is None else f" +- {factor * entry['sd']:.2f}"
    return f"{factor * entry['mean']:.2f}{spread}"


def _tell_precision(output: Output, held: PrecisionGrip) -> None:
    output.say(
        f"{held.grip} grip: thumb and fingers {math.degrees(held.opposition_rad):.0f} deg from opposed"
    )
    for name, angle in held.angles_rad.items():
        output.say(f"  {name} {math.degrees(angle):.1f} deg")
    for warning in held.warnings:
        output.say(f"  note: {warning}")


def _tell(output: Output, posture: Posture, way: GraspPath | None) -> None:
    output.say(
        f"{posture.grip} grip of {posture.hand.name}, method {posture.method}: "
        f"z {1e3 * posture.z_m:.3f} mm, alpha {math.degrees(posture.alpha_rad):.3f} deg, "
        f"aperture {math.degrees(posture.aperture_rad):.1f} deg"
    )
    for digit, radii in posture.radius_m.items():
        angles = [
            f"{name.removeprefix(digit + '_')} {math.degrees(angle):.1f}"
            for name, angle in posture.angles_rad.items()
            if name.startswith(digit)
        ]
        curved = ", ".join(f"{joint} {1e3 * value:.1f} mm" for joint, value in radii.items())
        output.say(f"  {digit}: {', '.join(angles)} deg; radius {curved}")
    touching = ", ".join(
        f"{at.digit} {at.link}" if at.digit != at.link else at.digit for at in posture.contacts
    )
    output.say(f"  contacts: {touching or 'none'}; penetration {1e3 * posture.penetration_m:.2f} mm")
    if way is not None:
        output.say(f"  the path starts at {math.degrees(way.start_pip_rad):.0f} deg of the middle joints")
    for warning in (*posture.warnings, *(way.warnings if way is not None else ())):
        output.say(f"  note: {warning}")
