"""Serves a viewport's page to browsers that may look."""

from __future__ import annotations

from collections.abc import Callable

from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response

from rehab_app.errors import Refused
from rehab_app.web.gateway.client_page import ClientPages
from rehab_app.web.presence import account_of
from rehab_app.web.site import Site

REFUSED_PARAMETERS = ("websocket", "playbackPath")
_GONE = 404


def picture(request: Request, pages: ClientPages, port_of: Callable[[Site, str], int]) -> Response:
    """The page of a viewport, behind sign-in and role.

    Args:
        request: The request.
        pages: Where the page is kept.
        port_of: The loopback port for the site and the recording in the path.
    """
    site: Site = request.app.state.site
    account = account_of(site, request)
    if account is None:
        return PlainTextResponse("Sign in first.", 401)
    if not account.may("view"):
        return PlainTextResponse("This account may not look at recordings.", 403)
    refused = [name for name in request.query_params if name in REFUSED_PARAMETERS]
    if refused:
        return _without_parameters(request)
    try:
        page = pages.get(port_of(site, str(request.path_params.get("recording", ""))))
    except Refused as refusal:
        return PlainTextResponse(str(refusal), _GONE)
    recording = str(request.path_params.get("recording", ""))
    if recording:
        site.clinic.audit.note_view(account, recording[:40], "review")
    headers = {
        "content-security-policy": page.policy,
        "x-frame-options": "SAMEORIGIN",
        "cache-control": "private, no-cache",
        "etag": page.tag,
        "vary": "accept-encoding",
    }
    if request.headers.get("if-none-match") == page.tag:
        return Response(status_code=304, headers=headers)
    if "gzip" in request.headers.get("accept-encoding", ""):
        return Response(page.gzipped, media_type="text/html", headers={**headers, "content-encoding": "gzip"})
    return Response(page.plain, media_type="text/html", headers=headers)


def _without_parameters(request: Request) -> Response:
    """The viewport writes its own address into its URL; a reload may repeat it. Anything else is refused."""
    own = f"{'wss' if request.url.scheme == 'https' else 'ws'}://{request.url.netloc}{request.url.path}"
    if list(request.query_params.multi_items()) == [("websocket", own.rstrip("/"))]:
        return RedirectResponse(request.url.path, 303)
    return PlainTextResponse("A viewport connects to this server only.", 400)


def endpoint(pages: ClientPages, port_of: Callable[[Site, str], int]) -> Callable[[Request], Response]:
    """A route's endpoint; Starlette runs it on a thread.

    Args:
        pages: Where the page is kept.
        port_of: The loopback port for the site and the recording in the path.
    """

    def answer(request: Request) -> Response:
        return picture(request, pages, port_of)

    return answer
