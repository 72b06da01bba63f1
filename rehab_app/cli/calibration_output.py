"""What calibrating says: words for people, figures as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import Any

from rehab_app.calibration import CalibratedCamera, IntrinsicsFit, Rejected, RigFit, WorldFit
from rehab_app.calibration.verdict import Verdict
from rehab_app.cli.output import Output


def say_intrinsics(output: Output, fit: IntrinsicsFit) -> None:
    """The lens in words."""
    found, std = fit.intrinsics, fit.intrinsics_std_px
    output.say(
        f"fx {found.fx_px:.1f} ± {std[0]:.1f}, fy {found.fy_px:.1f} ± {std[1]:.1f}, "
        f"cx {found.cx_px:.1f} ± {std[2]:.1f}, cy {found.cy_px:.1f} ± {std[3]:.1f} px; lens: {fit.model}."
    )
    steepest = degrees(max(view.tilt_rad for view in fit.views))
    output.say(
        f"{len(fit.views)} images, error {fit.rms_px:.3f} px rms, "
        f"corners in {100 * fit.coverage:.0f} % of the image, tilted up to {steepest:.0f}°."
    )
    _say_rejected(output, fit.rejected)
    _say_verdict(output, fit.verdict)


def intrinsics_json(fit: IntrinsicsFit, camera: CalibratedCamera) -> dict[str, Any]:
    """The lens as JSON: the calibration itself, and how well it is known."""
    return {
        **camera.table(),
        "digest": camera.digest,
        "std_px": dict(zip(("fx", "fy", "cx", "cy"), fit.intrinsics_std_px.tolist(), strict=True)),
        "distortion_std": fit.lens_std.tolist(),
        "lens_model": fit.model,
        "coverage": fit.coverage,
        "views": [
            {"source": view.source, "rms_px": view.rms_px, "tilt_rad": view.tilt_rad} for view in fit.views
        ],
        **_judged(fit.verdict, fit.rejected),
    }


def say_rig(output: Output, fit: RigFit, cameras: Sequence[CalibratedCamera]) -> None:
    """Places of cameras in words."""
    for number, camera in enumerate(cameras[1:], start=1):
        output.say(
            f"{camera.camera}: {1e3 * fit.baseline_m(number):.2f} ± {1e3 * fit.place_std_m[number]:.2f} mm "
            f"from {cameras[0].camera}, turned to ± {degrees(fit.turn_std_rad[number]):.3f}°."
        )
    output.say(f"{len(fit.used)} instants, error {fit.rms_px:.3f} px rms.")
    _say_rejected(output, fit.rejected)
    _say_verdict(output, fit.verdict)


def rig_json(fit: RigFit, cameras: Sequence[CalibratedCamera]) -> dict[str, Any]:
    """Places of cameras as JSON."""
    return {
        "cameras": [
            {
                **camera.table(),
                "digest": camera.digest,
                "baseline_m": fit.baseline_m(number),
                "camera_rms_px": float(fit.camera_rms_px[number]),
                "place_std_m": float(fit.place_std_m[number]),
                "turn_std_rad": float(fit.turn_std_rad[number]),
            }
            for number, camera in enumerate(cameras)
        ],
        "rms_px": fit.rms_px,
        "baseline_m": fit.baseline_m(),
        "used": list(fit.used),
        **_judged(fit.verdict, fit.rejected),
    }


def say_world(output: Output, fit: WorldFit) -> None:
    """A camera's place in the world, in words."""
    x, y, z = 1e3 * fit.placement.p_reference_camera_m
    output.say(
        f"The camera stands at x {x:.1f}, y {y:.1f}, z {z:.1f} mm of the board's first corner "
        f"(± {1e3 * fit.place_std_m:.2f} mm, ± {degrees(fit.turn_std_rad):.3f}°), "
        f"error {fit.placement.rms_px:.3f} px rms."
    )
    _say_rejected(output, fit.rejected)
    _say_verdict(output, fit.verdict)


def world_json(fit: WorldFit, camera: CalibratedCamera) -> dict[str, Any]:
    """A camera's place in the world, as JSON."""
    return {
        **_judged(fit.verdict, fit.rejected),
        **camera.table(),  # whose verdict is that of the lens where that is worse
        "digest": camera.digest,
        "turn_std_rad": fit.turn_std_rad,
        "place_std_m": fit.place_std_m,
        "used": list(fit.used),
    }


def say_camera(output: Output, camera: CalibratedCamera) -> None:
    """A calibration in words."""
    found = camera.intrinsics
    output.say(
        f"{camera.camera}: {found.width_px} x {found.height_px}, fx {found.fx_px:.1f}, fy {found.fy_px:.1f}, "
        f"cx {found.cx_px:.1f}, cy {found.cy_px:.1f} px, verdict {camera.verdict}."
    )
    lens = "none" if camera.lens.straight else " ".join(f"{value:.4g}" for value in camera.lens.coefficients)
    output.say(f"Lens: {lens}. {camera.method or 'Method unknown'}. Made {camera.created_utc or 'unknown'}.")
    for name, place in (("tracking camera", camera.placement), ("world", camera.world)):
        if place is not None:
            x, y, z = 1e3 * place.p_reference_camera_m
            output.say(f"In the frame of the {name}: x {x:.1f}, y {y:.1f}, z {z:.1f} mm.")
    output.say(f"Marker colour: {'learnt' if camera.colour else 'not learnt'}. Digest {camera.digest}.")


def _say_rejected(output: Output, rejected: Sequence[Rejected]) -> None:
    for item in rejected:
        output.say(f"Left out: {item.source} {item.reason}.")


def _say_verdict(output: Output, verdict: Verdict) -> None:
    output.say(f"{verdict.word.capitalize()}: {verdict.why}.")


def _judged(verdict: Verdict, rejected: Sequence[Rejected]) -> dict[str, Any]:
    return {
        "verdict": verdict.word,
        "why": verdict.why,
        "rejected": [{"source": item.source, "reason": item.reason} for item in rejected],
    }
