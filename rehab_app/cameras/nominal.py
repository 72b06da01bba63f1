"""A pinhole camera assumed of a source that states none, and the check that a given one fits."""

from __future__ import annotations

from math import radians, tan

from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

FIELD_OF_VIEW_DEG = 60.0
"""Assumed angle across the image's longer side: that of most webcams and telephones."""


def assumed(width_px: int, height_px: int, field_of_view_deg: float = FIELD_OF_VIEW_DEG) -> Intrinsics:
    """The pinhole camera of a source without calibration: square pixels, centred, a usual field of view."""
    focal_px = 0.5 * max(width_px, height_px) / tan(0.5 * radians(field_of_view_deg))
    return Intrinsics(focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1), width_px, height_px)


def fitting(given: Intrinsics | None, width_px: int, height_px: int, source: str) -> Intrinsics:
    """The given camera if it has the size of the images, else a refusal; an assumed one if none is given.

    Raises:
        Refused: The intrinsics were measured at another resolution.
    """
    if given is None:
        return assumed(width_px, height_px)
    if (given.width_px, given.height_px) != (width_px, height_px):
        raise Refused(
            f"resolution of the camera intrinsics for {source}",
            f"{given.width_px} x {given.height_px} px",
            f"{width_px} x {height_px} px, as its images are",
            "calibrate the camera at this resolution, or choose the other one",
        )
    return given
