"""Devices and calibration: what the clinic measures and moves with, and how to calibrate a camera."""

from __future__ import annotations

import time

from starlette.responses import Response

from rehab_app.services.clock import local_day
from rehab_app.services.devices import BOARD_KINDS
from rehab_app.web.language import _
from rehab_app.web.visit import Visit
from rehab_app.web.words import ROBOTS
from rehab_app.web.words_cameras import STATES, camera_remedy

_MEDIA = {"pdf": "application/pdf", "svg": "image/svg+xml"}


def devices(visit: Visit) -> Response:
    """Cameras and robots, and how the last run kept its time."""
    clinic = visit.site.clinic
    snapshot = clinic.live.snapshot()
    return visit.page(
        "devices.html.j2",
        say=_,
        cameras=clinic.devices.cameras(),
        states=STATES,
        remedy=camera_remedy,
        robots=clinic.devices.robots(),
        advice=clinic.devices.advice(),
        names=ROBOTS,
        desk=snapshot,
        ages=_ages(visit),
    )


def calibration(visit: Visit) -> Response:
    """Every calibration that is kept, and how to make one."""
    return visit.page(
        "calibration.html.j2",
        rows=visit.site.clinic.calibrations.list(),
        ages=_ages(visit),
        kinds=BOARD_KINDS,
    )


def board(visit: Visit) -> Response:
    """A board to print."""
    kind = visit.part("kind")
    content = visit.site.clinic.devices.board(kind)
    disposition = f'attachment; filename="calibration-board.{kind}"'
    return Response(content, media_type=_MEDIA[kind], headers={"content-disposition": disposition})


def _ages(visit: Visit) -> dict[str, int]:
    """Age of every calibration in days, by its digest."""
    today = local_day(time.time_ns())
    rows = visit.site.clinic.calibrations.list()
    return {row.digest: (today - local_day(row.created_utc_ns)).days for row in rows}
