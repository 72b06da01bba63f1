"""Sign-in, sign-out, the covered page, and the first account."""

from __future__ import annotations

import ipaddress

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from rehab_app.access import Account
from rehab_app.errors import NoAnswer, Refused
from rehab_app.web.language import _
from rehab_app.web.presence import (
    COOKIE,
    account_of,
    covers,
    present,
    sign_in_cookie,
    take_cookie,
    ticket_of,
)
from rehab_app.web.refusals import sentence_of
from rehab_app.web.render import render
from rehab_app.web.site import Site
from rehab_app.web.stop import is_local
from rehab_app.web.visit import KEPT, Visit, form_of, wants_json


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


async def unlock(request: Request) -> Response:
    """Check the password of whoever's page is covered; what is on the page stays."""
    form = await form_of(request)
    return await run_in_threadpool(_unlock, request, form)


async def here(request: Request) -> Response:
    """Whether this browser's sign-in holds, is locked, and how long it was idle; asking is no use of it."""
    return await run_in_threadpool(_here, request)


async def set_up_page(request: Request) -> Response:
    """The form of the first account."""
    return await run_in_threadpool(_set_up_page, request, "", "")


async def set_up(request: Request) -> Response:
    """Make the first account, the administrator's."""
    form = await form_of(request)
    return await run_in_threadpool(_set_up, request, form)


def still_here(visit: Visit) -> Response:
    """Somebody typed or clicked on a page: the sign-in is in use."""
    del visit  # the request itself is the use
    return JSONResponse({"state": "open"})


def sign_out(visit: Visit) -> Response:
    """End this sign-in."""
    visit.site.clinic.accounts.sign_ins.end(visit.ticket.name, visit.ticket.digest)
    visit.site.clinic.audit.note_later(visit.account.name, "sign out")
    visit.site.kept_forms.drop(visit.request.cookies.get(KEPT, ""))
    answer = RedirectResponse("/sign-in", 303)
    take_cookie(answer, COOKIE, visit.request)
    return answer


def _start(request: Request) -> Response:
    site: Site = request.app.state.site
    account = account_of(site, request)
    if account is not None:
        return RedirectResponse("/live" if account.may("view") else "/mine", 303)
    return RedirectResponse("/set-up" if site.clinic.accounts.set_up_needed() else "/sign-in", 303)


def _sign_in_page(request: Request, name: str = "", sentence: str = "", status: int = 200) -> Response:
    site: Site = request.app.state.site
    if site.clinic.accounts.set_up_needed():
        return RedirectResponse("/set-up", 303)
    wanted = request.query_params.get("next", "")
    there = present(site, request)
    locked = there is not None and there.locked
    return render(
        site,
        request,
        "sign_in.html.j2",
        status=status,
        name=there.account.name if there is not None and locked and not name else name,
        locked=locked,
        kept=wanted == "/kept",
        sentence=sentence,
        wanted=wanted if is_local(wanted) else "",
    )


def _sign_in(request: Request, form: dict[str, str]) -> Response:
    name = form.get("name", "").strip()
    try:
        account = _proven(request, name, form.get("password", ""))
    except Refused as refusal:
        return _sign_in_page(request, name, sentence_of(refusal), 403)
    wanted = form.get("next", "")
    return _signed_in(request, account.name, wanted if is_local(wanted) else "/")


def _unlock(request: Request, form: dict[str, str]) -> Response:
    """The same person goes on; where the sign-in has ended meanwhile, a new one begins."""
    site: Site = request.app.state.site
    owner = site.seal.read_old(request.cookies.get(COOKIE))
    name = form.get("name", "").strip()
    back = form.get("back", "")
    try:
        if owner is None or owner.name != name:
            raise Refused("sign-in", "another person's", f"that of {name[:60]}", "sign in anew")
        account = _proven(request, name, form.get("password", ""), again=True)
    except Refused as refusal:
        if wants_json(request):
            return JSONResponse({"message": sentence_of(refusal)}, 403)
        return _sign_in_page(request, name, sentence_of(refusal), 403)
    to_script = wants_json(request)
    answer: Response = RedirectResponse(back if is_local(back) else "/", 303)
    if present(site, request) is not None:
        site.clinic.accounts.sign_ins.touch(owner.digest)
        token = site.seal.form_token(owner)
        return JSONResponse({"state": "open", "token": token}) if to_script else answer
    token = sign_in_cookie(site, answer, account.name, request)
    return _as_json(answer, {"state": "open", "token": token}) if to_script else answer


def _as_json(answer: Response, said: dict[str, str]) -> Response:
    """What a script is told, with the cookies of another answer."""
    told = JSONResponse(said)
    for value in answer.headers.getlist("set-cookie"):
        told.headers.append("set-cookie", value)
    return told


def _here(request: Request) -> Response:
    site: Site = request.app.state.site
    ticket, there = ticket_of(site, request), present(site, request)
    if ticket is None or there is None:
        return JSONResponse({"state": "out"})
    held = site.clinic.accounts.sign_ins.look(ticket.name, ticket.digest)
    idle_s = 0.0 if held is None or not covers(there.account) else held.idle_s
    return JSONResponse({"state": "locked" if there.locked else "open", "idle_s": round(idle_s, 1)})


def _proven(request: Request, name: str, password: str, again: bool = False) -> Account:
    """The account of a name and password, braked by network address too.

    Raises:
        Refused: They are wrong, or there were too many tries.
    """
    site: Site = request.app.state.site
    address, accounts = _address(request), site.clinic.accounts
    site.sign_in_limit.check(address)  # not counted again: a try while waiting does not prolong the wait
    try:
        with site.signing_in:
            account = (accounts.unlock if again else accounts.sign_in)(name, password)
    except NoAnswer:  # nobody guessed anything
        raise
    except Refused:
        site.sign_in_limit.fail(address)
        raise
    site.sign_in_limit.succeed(address)
    return account


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
        return _set_up_page(request, name, _("The two passwords differ: type the same one twice."))
    try:
        account = site.clinic.accounts.set_up(name, form.get("password", ""))
    except Refused as refusal:
        return _set_up_page(request, name, str(refusal))
    return _signed_in(request, account.name, "/patients")


def _signed_in(request: Request, name: str, path: str) -> Response:
    answer = RedirectResponse(path, 303)
    sign_in_cookie(request.app.state.site, answer, name, request)
    return answer


def _address(request: Request) -> str:
    return "unknown" if request.client is None else request.client.host


def _is_this_machine(request: Request) -> bool:
    """The first account is made at the server itself, so that nobody on the network is faster."""
    try:
        return ipaddress.ip_address(_address(request)).is_loopback
    except ValueError:
        return False
