"""Sign-in, sign-out and the first account."""

from __future__ import annotations

import ipaddress

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response

from rehab_app.access import CONSOLE
from rehab_app.errors import Refused
from rehab_app.web.render import render
from rehab_app.web.site import Site
from rehab_app.web.stop import is_local
from rehab_app.web.visit import COOKIE, Visit, account_of, form_of, sign_in_cookie, ticket_of


async def start(request: Request) -> Response:
    """Where a browser begins: the live page, the sign-in, or the first account."""
    return await run_in_threadpool(_start, request)


async def sign_in_page(request: Request) -> Response:
    """The form that asks for name and password."""
    return await run_in_threadpool(_sign_in_page, request)


async def sign_in(request: Request) -> Response:
    """Check name and password."""
    form = await form_of(request)
    return await run_in_threadpool(_sign_in, request, form)


async def set_up_page(request: Request) -> Response:
    """The form of the first account."""
    return await run_in_threadpool(_set_up_page, request, "", "")


async def set_up(request: Request) -> Response:
    """Make the first account, the administrator's."""
    form = await form_of(request)
    return await run_in_threadpool(_set_up, request, form)


def sign_out(visit: Visit) -> Response:
    """End this sign-in."""
    visit.site.seal.end(visit.ticket)
    answer = RedirectResponse("/sign-in", 303)
    answer.delete_cookie(COOKIE, httponly=True, samesite="strict")
    return answer


def _start(request: Request) -> Response:
    site: Site = request.app.state.site
    account = account_of(site, ticket_of(site, request))
    if account is not None:
        return RedirectResponse("/live" if account.may("view") else "/sign-in", 303)
    return RedirectResponse("/set-up" if site.clinic.accounts.set_up_needed() else "/sign-in", 303)


def _sign_in_page(request: Request, name: str = "", sentence: str = "", status: int = 200) -> Response:
    site: Site = request.app.state.site
    if site.clinic.accounts.set_up_needed():
        return RedirectResponse("/set-up", 303)
    wanted = request.query_params.get("next", "")
    return render(
        site,
        request,
        "sign_in.html.j2",
        status=status,
        name=name,
        sentence=sentence,
        wanted=wanted if is_local(wanted) else "",
    )


def _sign_in(request: Request, form: dict[str, str]) -> Response:
    site: Site = request.app.state.site
    name, address = form.get("name", "").strip(), _address(request)
    try:
        site.sign_in_limit.check(address)
    except Refused as refusal:  # not counted again: a try while waiting does not prolong the wait
        return _sign_in_page(request, name, f"Sign-in: {refusal}", 403)
    try:
        with site.signing_in:
            account = site.clinic.accounts.sign_in(name, form.get("password", ""))
    except Refused as refusal:
        site.sign_in_limit.fail(address)
        return _sign_in_page(request, name, f"Sign-in: {refusal}", 403)
    site.sign_in_limit.succeed(address)
    wanted = form.get("next", "")
    return _signed_in(request, account.name, wanted if is_local(wanted) else "/")


def _set_up_page(request: Request, name: str, sentence: str) -> Response:
    site: Site = request.app.state.site
    if not site.clinic.accounts.set_up_needed():
        return RedirectResponse("/sign-in", 303)
    here = _is_this_machine(request)
    status = 409 if sentence else 200 if here else 403
    return render(site, request, "set_up.html.j2", status=status, name=name, sentence=sentence, here=here)


def _set_up(request: Request, form: dict[str, str]) -> Response:
    site: Site = request.app.state.site
    name = form.get("name", "").strip()
    if not site.clinic.accounts.set_up_needed() or not _is_this_machine(request):
        return _set_up_page(request, name, "")
    if form.get("password", "") != form.get("again", ""):
        return _set_up_page(request, name, "The two passwords differ: type the same one twice.")
    try:
        account = site.clinic.accounts.add_user(name, "administrator", form.get("password", ""), CONSOLE)
    except Refused as refusal:
        return _set_up_page(request, name, str(refusal))
    return _signed_in(request, account.name, "/patients")


def _signed_in(request: Request, name: str, path: str) -> Response:
    answer = RedirectResponse(path, 303)
    sign_in_cookie(request.app.state.site, answer, name, secure=request.url.scheme == "https")
    return answer


def _address(request: Request) -> str:
    return "unknown" if request.client is None else request.client.host


def _is_this_machine(request: Request) -> bool:
    """The first account is made at the server itself, so that nobody on the network is faster."""
    try:
        return ipaddress.ip_address(_address(request)).is_loopback
    except ValueError:
        return False
