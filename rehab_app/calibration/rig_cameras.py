"""From the pictures of several cameras to calibrated cameras that know where they stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rehab_app.calibration.board import Board
from rehab_app.calibration.camera import CalibratedCamera, Placement, check_size
from rehab_app.calibration.corners import Corners, Rejected
from rehab_app.calibration.intrinsics import calibrate_intrinsics
from rehab_app.calibration.rig import RigFit
from rehab_app.calibration.verdict import worse
from rehab_app.errors import Refused


def cameras_of(
    seen: Sequence[Sequence[Corners | Rejected]],
    board: Board,
    given: Sequence[CalibratedCamera],
    identities: Sequence[str],
) -> list[CalibratedCamera]:
    """The cameras whose places are wanted; those that were not calibrated are, from the same pictures.

    Args:
        seen: What was found in the pictures of each camera.
        board: The board.
        given: The calibration of each camera in order, or none at all.
        identities: The id of each camera in order, or none at all.

    Raises:
        Refused: The counts differ, two cameras share an id, or pictures do not fit a calibration.
    """
    for thing, items in (("calibrations of the cameras", given), ("ids of the cameras", identities)):
        if items and len(items) != len(seen):
            raise Refused(
                f"number of {thing}", str(len(items)), f"{len(seen)} like the cameras", "give one for each"
            )
    cameras = list(given) or [
        _calibrated(one, board, f"camera-{number}") for number, one in enumerate(seen, start=1)
    ]
    named = [
        replace(camera, camera=identities[number] if identities else camera.camera)
        for number, camera in enumerate(cameras)
    ]
    names = [camera.camera for camera in named]
    if len(set(names)) < len(names):
        raise Refused("ids of the cameras", ", ".join(names), "different", "name each with --id")
    for camera, one in zip(named, seen, strict=True):
        for item in one:
            if isinstance(item, Corners):
                check_size(camera, *item.size_px, item.source)
    return named


def placed(fit: RigFit, cameras: Sequence[CalibratedCamera], board: Board) -> list[CalibratedCamera]:
    """The cameras with their places; a camera is worth no more than its place is known.

    Args:
        fit: Where they stand.
        cameras: The cameras in the same order.
        board: The board.
    """
    reference = cameras[0].camera
    method = f"{board.description}; {len(fit.used)} instants"
    return [
        replace(
            camera,
            placement=Placement(
                reference, view.rotation_tracking_camera, view.p_tracking_camera_m, fit.rms_px
            ),
            method="; beside it ".join(filter(None, (camera.method, method))),
            verdict=worse(camera.verdict, fit.verdict.word),
        ).now()
        for camera, view in zip(cameras, fit.views, strict=True)
    ]


def _calibrated(seen: Sequence[Corners | Rejected], board: Board, name: str) -> CalibratedCamera:
    fit = calibrate_intrinsics(seen, board)
    return CalibratedCamera(
        camera=name,
        intrinsics=fit.intrinsics,
        lens=fit.lens,
        method=f"{board.description}; {len(fit.views)} images",
        rms_px=fit.rms_px,
        verdict=fit.verdict.word,
    )
