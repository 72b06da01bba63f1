"""Markers named by hand: the first picture of a take, its rings, and tracking again from the names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.recording.labels import labels_of
from rehab_app.services.marker_names import FEWEST, FirstPicture
from rehab_app.services.snapshot import BUSY
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.visit import Visit

_MARGIN = 0.2
_SMALLEST = 0.3


@dataclass(frozen=True, slots=True)
class Box:
    """Part of a picture, px."""

    left: float
    top: float
    width: float
    height: float


def names(visit: Visit) -> Response:
    """The page on which markers are named."""
    row = visit.site.clinic.takes.get(catalogue_id(visit.part("recording")))
    why_not = visit.site.clinic.marker_names.why_not(row.id)
    picture = None if why_not else visit.site.clinic.marker_names.first_picture(row.id, visit.account)
    return visit.page(
        "names.html.j2",
        take=row,
        why_not=why_not,
        picture=picture,
        blobs=() if picture is None else picture.blobs_px.round(1).tolist(),
        box=None if picture is None else _around(picture),
        fewest=FEWEST,
    )


def picture(visit: Visit) -> Response:
    """The first picture itself."""
    named = catalogue_id(visit.part("recording"))
    shown = visit.site.clinic.marker_names.first_picture(named, visit.account)
    return Response(shown.jpeg, media_type="image/jpeg")


def track_again(visit: Visit) -> Response:
    """Track the take from the names: a new take, which is shown; not while the robot moves."""
    named = catalogue_id(visit.part("recording"))
    labels = labels_of(visit.asked("labels").split())
    if labels is None:
        raise Refused("take", "with no named markers", f"{FEWEST} or more", "click on markers")
    clinic = visit.site.clinic
    if clinic.live.snapshot().state in BUSY:
        raise Refused("live desk", "at work", "idle", "wait until it is done, then track again")
    made = clinic.marker_names.track_again(named, labels, visit.account)
    result = made.result
    sentence = (
        f"Take {made.take.id} was tracked again from {len(labels.names)} names: "
        f"{100 * result.measured_share:.0f} % measured, {100 * result.estimated_share:.0f} % estimated, "
        f"{100 * result.lost_share:.0f} % lost. Take {named} stays as it was."
    )
    return visit.go_and_say(f"/takes/{made.take.id}", sentence)


def _around(picture: FirstPicture) -> Box:
    """The part that holds all rings, of the picture's shape: a hand far away is shown large."""
    if not len(picture.blobs_px):
        return Box(0.0, 0.0, picture.width_px, picture.height_px)
    size = np.array([picture.width_px, picture.height_px], dtype=np.float64)
    low, high = picture.blobs_px.min(axis=0), picture.blobs_px.max(axis=0)
    share = min(max(float(((high - low) / size).max()) * (1.0 + 2.0 * _MARGIN), _SMALLEST), 1.0)
    corner = np.clip(0.5 * (low + high) - 0.5 * share * size, 0.0, (1.0 - share) * size)
    left, top, width, height = np.concatenate([corner, share * size]).round(1).tolist()
    return Box(left, top, width, height)
