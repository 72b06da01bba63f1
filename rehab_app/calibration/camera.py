"""A calibrated camera: what a session names by digest and a tracker needs to know."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from rehab_app.calibration.plausible import check_intrinsics
from rehab_app.calibration.rig_problem import Known
from rehab_app.errors import Refused
from rehab_app.geometry.lens import STRAIGHT, Lens
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import View
from sessions.records.fields import Float64

FORMAT = "rehab-app camera calibration"
FORMAT_VERSION = 1
_LONGEST_ID = 200


@dataclass(frozen=True, slots=True)
class Placement:
    """Where a camera stands: ``T_reference_camera``.

    Attributes:
        reference: In whose frame: the id of the tracking camera, or "world".
        rotation_reference_camera: Rotation from the camera's frame to the reference's, shape (3, 3).
        p_reference_camera_m: Optical centre in the reference's frame, shape (3,).
        rms_px: Residual of the calibration that found it.

    Raises:
        Refused: The matrix is no rotation, or a number is not finite.
    """

    reference: str
    rotation_reference_camera: Float64
    p_reference_camera_m: Float64
    rms_px: float

    def __post_init__(self) -> None:
        turn, p_m = self.rotation_reference_camera, self.p_reference_camera_m
        whole = turn.shape == (3, 3) and p_m.shape == (3,) and bool(np.isfinite(p_m).all())
        if not (whole and np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) and np.linalg.det(turn) > 0):
            raise Refused(
                "place of the camera", "no rotation and translation", "a rigid pose", "calibrate again"
            )

    def view(self, index: int) -> View:
        """The same for a tracker, as camera number ``index``."""
        return View(index, self.rotation_reference_camera, self.p_reference_camera_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibratedCamera:
    """A camera whose lens is known and, where calibrated, its place and the colour of the markers before it.

    Attributes:
        camera: Id of the camera, such as ``webcam:0``; never a person's name.
        intrinsics: Pinhole camera after the lens is removed, at the resolution of the images.
        lens: Distortion that the raw image has.
        method: How it was found, one phrase.
        rms_px: Distance of found from predicted corners, NaN where unknown.
        verdict: "good", "usable", "redo", or "unknown" of a file that does not say.
        created_utc: ISO time in UTC, empty of a file that does not say.
        placement: Pose in the tracking camera's frame, None where it stands alone.
        world: Pose in the world, None where unknown.
        colour: JSON of the colour model of the markers, empty where none was learnt.

    Raises:
        Refused: The intrinsics do not fit their image, or the id cannot be one.
    """

    camera: str
    intrinsics: Intrinsics
    lens: Lens = STRAIGHT
    method: str = ""
    rms_px: float = math.nan
    verdict: str = "unknown"
    created_utc: str = ""
    placement: Placement | None = None
    world: Placement | None = None
    colour: str = ""

    def __post_init__(self) -> None:
        check_intrinsics(self.intrinsics, f"intrinsics of camera {self.camera}")
        if not 0 < len(self.camera) <= _LONGEST_ID or not self.camera.isprintable():
            raise Refused(
                "camera id", repr(self.camera[:40]), f"1 to {_LONGEST_ID} printable characters", "shorten it"
            )

    @property
    def digest(self) -> str:
        """SHA-256 over the canonical JSON of everything above: what sessions store."""
        return digest_of(self.table())

    @property
    def known(self) -> Known:
        """The pinhole and the lens alone."""
        return Known(self.intrinsics, self.lens)

    def view(self, index: int = 0) -> View:
        """Its place for a tracker; that of the tracking camera itself where it stands alone."""
        if self.placement is None:
            return View(index, np.eye(3), np.zeros(3))
        return self.placement.view(index)

    def now(self) -> CalibratedCamera:
        """The same, as a new version made at this moment."""
        return replace(self, created_utc=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S.%fZ"))

    def table(self) -> dict[str, Any]:
        """What lies in a file, but for the digest; units stand in the names."""
        found = self.intrinsics
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "camera": self.camera,
            "width_px": found.width_px,
            "height_px": found.height_px,
            "fx_px": float(found.fx_px),
            "fy_px": float(found.fy_px),
            "cx_px": float(found.cx_px),
            "cy_px": float(found.cy_px),
            "distortion": list(self.lens.coefficients),
            "method": self.method,
            "rms_px": self.rms_px if math.isfinite(self.rms_px) else None,
            "verdict": self.verdict,
            "created_utc": self.created_utc,
            "placement": _placement_table(self.placement),
            "world": _placement_table(self.world),
            "colour": json.loads(self.colour) if self.colour else None,
        }


def digest_of(table: dict[str, Any]) -> str:
    """SHA-256 over the table as JSON with sorted keys and without blanks."""
    content = {key: value for key, value in table.items() if key != "digest"}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def check_size(calibration: CalibratedCamera, width_px: int, height_px: int, thing: str) -> None:
    """Refuse images of another resolution than that of the calibration.

    Args:
        calibration: The calibrated camera.
        width_px: Width of the images.
        height_px: Height of the images.
        thing: Whose images they are.

    Raises:
        Refused: The sizes differ.
    """
    known = calibration.intrinsics
    if (width_px, height_px) != (known.width_px, known.height_px):
        raise Refused(
            f"resolution of {thing}",
            f"{width_px} x {height_px}",
            f"{known.width_px} x {known.height_px} as calibrated",
            "set the camera to that resolution, or calibrate it at this one",
        )


def _placement_table(placement: Placement | None) -> dict[str, Any] | None:
    if placement is None:
        return None
    return {
        "reference": placement.reference,
        "rotation": placement.rotation_reference_camera.tolist(),
        "p_m": placement.p_reference_camera_m.tolist(),
        "rms_px": placement.rms_px if math.isfinite(placement.rms_px) else None,
    }
