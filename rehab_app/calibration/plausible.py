"""Refuses numbers that are those of no camera, or of a camera at another resolution."""

from __future__ import annotations

import math

from rehab_app.errors import Refused
from rehab_app.geometry.pinhole import Intrinsics

_FOCAL_SHARE = (0.15, 20.0)  # of the longer side of the image: 147 degrees wide to a telescope
_ASPECT = 2.0
_CENTRE_SHARE = (0.3, 0.7)  # of the image, in which the principal point lies
_LARGEST_PX = 20_000


def check_intrinsics(intrinsics: Intrinsics, thing: str = "camera intrinsics") -> None:
    """Refuse intrinsics that do not fit their own image.

    Args:
        intrinsics: Focal lengths, principal point and image size.
        thing: What a refusal names.

    Raises:
        Refused: A number is not finite, or they are not those of a camera with images of this size.
    """
    focal = {"fx": intrinsics.fx_px, "fy": intrinsics.fy_px}
    centre = {"cx": (intrinsics.cx_px, intrinsics.width_px), "cy": (intrinsics.cy_px, intrinsics.height_px)}
    if not all(math.isfinite(number) for number in (*focal.values(), intrinsics.cx_px, intrinsics.cy_px)):
        raise Refused(thing, "not all finite", "six finite numbers", "calibrate the camera again")
    size = f"{intrinsics.width_px} x {intrinsics.height_px}"
    longer = max(intrinsics.width_px, intrinsics.height_px)
    if longer > _LARGEST_PX:
        raise Refused(thing, f"for {size} px", f"at most {_LARGEST_PX} px wide and high", "check the file")
    for name, value in focal.items():
        _check(thing, name, value, _FOCAL_SHARE, longer, size)
    if not 1 / _ASPECT <= intrinsics.fx_px / intrinsics.fy_px <= _ASPECT:
        shown = f"fx = {intrinsics.fx_px:g} and fy = {intrinsics.fy_px:g} px"
        raise Refused(thing, shown, "nearly the same", "calibrate the camera again")
    for name, (value, side) in centre.items():
        _check(thing, name, value, _CENTRE_SHARE, side, size)


def _check(thing: str, name: str, value: float, share: tuple[float, float], side: int, size: str) -> None:
    low, high = share[0] * side, share[1] * side
    if not low <= value <= high:
        raise Refused(
            thing,
            f"{name} = {value:g} px for images of {size}",
            f"{low:.0f} to {high:.0f} px there",
            "give the intrinsics of this camera at this resolution, in pixels",
        )
