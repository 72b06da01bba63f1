"""What ``rehab-app grasp`` prints: postures, paths, grips between fingertips, shapes of hands."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.grasp.posture import Posture
    from rehab_app.grasp.precision import PrecisionGrip
    from rehab_app.grasp.spiral import GraspPath

_DEG = 180.0 / math.pi


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
        "not_touching": not_touching(posture),
        "penetration_m": posture.penetration_m,
        "arc_rad": posture.arc_rad,
        "aperture_rad": posture.aperture_rad,
        "warnings": list(posture.warnings),
    }


def not_touching(posture: Posture) -> list[str]:
    """Digits that do not touch the object in this posture."""
    from sessions.records import DIGITS

    touching = {contact.digit for contact in posture.contacts}
    return [digit for digit in DIGITS if digit not in touching]


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


def tell_shape(output: Output, takes: list[Path]) -> None:
    """Measure the hands in takes and say what came of it."""
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


def tell_precision(output: Output, held: PrecisionGrip) -> None:
    """Say a grip between fingertips."""
    output.say(
        f"{held.grip} grip: thumb and fingers {math.degrees(held.opposition_rad):.0f} deg from opposed"
    )
    for name, angle in held.angles_rad.items():
        output.say(f"  {name} {math.degrees(angle):.1f} deg")
    for warning in held.warnings:
        output.say(f"  note: {warning}")


def tell_posture(output: Output, posture: Posture, way: GraspPath | None) -> None:
    """Say a posture, and where its path begins."""
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
