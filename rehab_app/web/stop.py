"""The emergency stop of the shell, and its release."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from rehab_app.web.language import _
from rehab_app.web.presence import ticket_of
from rehab_app.web.site import Site
from rehab_app.web.visit import Visit, wants_json

CONFIRMED = "looked"


async def press(request: Request) -> Response:
    """Stop: anybody, signed in or not. No data base, no form token (the guard checked the Origin)."""
    site: Site = request.app.state.site
    ticket = ticket_of(site, request)
    site.clinic.live.press_stop("unnamed" if ticket is None else ticket.name)
    if wants_json(request):
        return JSONResponse({"stopped": True})
    return RedirectResponse("/", 303)


async def state(request: Request) -> Response:
    """Whether stop is pressed; every page asks once a second."""
    site: Site = request.app.state.site
    return JSONResponse({"stopped": bool(site.clinic.live.snapshot().stop_source)})


def clear(visit: Visit) -> Response:
    """Release the stop; the service asks for the role and the confirmation."""
    visit.site.clinic.live.clear_stop(visit.account, visit.asked(CONFIRMED) == "yes")
    back = visit.asked("back")
    return visit.go(back if is_local(back) else "/", _("The stop was cleared."))


def is_local(path: str) -> bool:
    """Whether a path leads to a page of this server and nowhere else."""
    return path.startswith("/") and not path.startswith(("//", "/\\")) and path.isprintable()
