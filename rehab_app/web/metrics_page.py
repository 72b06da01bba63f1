"""The page /metrics: to this machine, or to whoever brings the token that a person set."""

from __future__ import annotations

import hmac
import ipaddress

from prometheus_client import CONTENT_TYPE_LATEST
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from rehab_app.web.meters import Meters
from rehab_app.web.site import Site

_BEARER = "Bearer "


async def metrics(request: Request) -> Response:
    """Everything that is measured, in Prometheus' text format."""
    site: Site = request.app.state.site
    meters: Meters = request.app.state.meters
    if not may_read(request, site.clinic.settings.metrics.token):
        return PlainTextResponse("The metrics are not for this address.", 403)
    return Response(await run_in_threadpool(meters.text), media_type=CONTENT_TYPE_LATEST)


def may_read(request: Request, token: str) -> bool:
    """Whether somebody may read the metrics.

    Args:
        request: Who asks.
        token: The token that a person set; with one, everybody needs it.
    """
    if token:
        brought = request.headers.get("authorization", "")
        return hmac.compare_digest(brought.encode(), (_BEARER + token).encode())
    address = "" if request.client is None else request.client.host
    # Behind a proxy on this machine every visitor comes from loopback: then only a token opens the page.
    return _is_loopback(address) and "x-forwarded-for" not in request.headers


def _is_loopback(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False
