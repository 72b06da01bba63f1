"""Where calibrated cameras stand in the frame of the first: what a tracker of several cameras needs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rehab_app.calibration.camera import CalibratedCamera, Placement
from rehab_app.errors import Refused
from rehab_app.geometry.view import PRIMARY, View


def views_of(cameras: Sequence[CalibratedCamera]) -> tuple[View, ...]:
    """The poses of cameras in the frame of the first, by what all of them were calibrated to.

    That is the tracking camera's frame of one ``calibrate stereo``, else the world of one board. A single
    camera needs no place.

    Args:
        cameras: The cameras, the tracking camera first.

    Raises:
        Refused: They were not calibrated to the same thing, or one not at all.
    """
    if len(cameras) < 2:
        return (PRIMARY,)
    for places in ([one.placement for one in cameras], [one.world for one in cameras]):
        known = [place for place in places if place is not None]
        if len(known) == len(cameras) and len({place.reference for place in known}) == 1:
            return tuple(_beside(known[0], place, index) for index, place in enumerate(known))
    names = ", ".join(one.camera for one in cameras)
    raise Refused(
        f"place of the cameras {names}",
        "not known beside each other",
        "calibrated together",
        "run rehab-app calibrate stereo with images of all of them, and give the files that it makes",
    )


def _beside(first: Placement, other: Placement, index: int) -> View:
    if index == 0:
        return PRIMARY
    to_first = first.rotation_reference_camera.T
    away_m = other.p_reference_camera_m - first.p_reference_camera_m
    return View(index, np.asarray(to_first @ other.rotation_reference_camera), to_first @ away_m)
