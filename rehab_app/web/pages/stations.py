"""The clinic's stations: which are heard, how their clocks stand, who is in therapy where."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.web.visit import Visit


def stations(visit: Visit) -> Response:
    """The page."""
    held = visit.site.clinic.stations
    listed = held.list(visit.account)
    told = {one.warning for one in listed}
    return visit.page(
        "stations.html.j2",
        stations=listed,
        trouble="" if held.trouble in told else held.trouble,
        shared=bool(visit.site.clinic.settings.catalogue_url),
    )
