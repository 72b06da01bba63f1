"""One request of somebody: who they are, what they sent, and how they are answered."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias
from urllib.parse import quote

from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from rehab_app.access import Account, Verb
from rehab_app.errors import REFUSALS, Refused, RobotRefused
from rehab_app.web.render import render
from rehab_app.web.signing import LIFETIME_S, Ticket
from rehab_app.web.site import Site

COOKIE = "rehab_sign_in"
NOTICE = "rehab_notice"


@dataclass(frozen=True, slots=True)
class Visit:
    """A request of a signed-in person.

    Attributes:
        site: The site.
        request: The request.
        account: Who asks.
        ticket: Their sign-in.
        form: What they sent; empty for a page that is only looked at.
    """

    site: Site
    request: Request
    account: Account
    ticket: Ticket
    form: Mapping[str, str]

    def part(self, name: str) -> str:
        """A part of the path."""
        return str(self.request.path_params[name])

    def asked(self, name: str) -> str:
        """A form field, "" where it was not sent."""
        return self.form.get(name, "").strip()

    def page(self, template: str, *, status: int = 200, **values: object) -> Response:
        """Render a page for this person."""
        return render(
            self.site,
            self.request,
            template,
            visitor=self.account,
            ticket=self.ticket,
            status=status,
            **values,
        )

    def go(self, path: str, notice: str = "", good: bool = True) -> Response:
        """Send the browser on, with a sentence for the next page; or answer a script with the sentence."""
        if wants_json(self.request):
            return JSONResponse({"message": notice, "path": path})
        answer = RedirectResponse(path, 303)
        if notice:
            self._keep_notice(answer, notice, good)
        return answer

    def go_and_say(self, path: str, notice: str) -> Response:
        """As ``go``, for a script that opens ``path``: the sentence is kept for that page too."""
        answer = self.go(path, notice)
        if wants_json(self.request):
            self._keep_notice(answer, notice, good=True)
        return answer

    def _keep_notice(self, answer: Response, notice: str, good: bool) -> None:
        kept = self.site.seal.notice(notice, good)
        answer.set_cookie(NOTICE, kept, max_age=60, httponly=True, samesite="strict")


Endpoint: TypeAlias = Callable[[Request], Awaitable[Response]]
Answer: TypeAlias = Callable[[Visit], Response]


def page(answer: Answer, verb: Verb = "view") -> Endpoint:
    """A page that is looked at.

    Args:
        answer: Runs on a thread, not on the event loop.
        verb: What the role must allow.
    """

    async def endpoint(request: Request) -> Response:
        return await run_in_threadpool(_looked_at, request, answer, verb)

    return endpoint


def action(answer: Answer, verb: Verb, back: str) -> Endpoint:
    """A form or a script's request that does something.

    Args:
        answer: Runs on a thread.
        verb: What the role must allow; the service asks again.
        back: Page that shows the sentence of a refusal.
    """

    async def endpoint(request: Request) -> Response:
        form = await form_of(request)
        return await run_in_threadpool(_acted_on, request, form, answer, verb, back)

    return endpoint


def ticket_of(site: Site, connection: HTTPConnection) -> Ticket | None:
    """The sign-in that a request carries; asks no data base."""
    return site.seal.read(connection.cookies.get(COOKIE))


def account_of(site: Site, ticket: Ticket | None) -> Account | None:
    """The account of a ticket, None where nobody is signed in."""
    if ticket is None:
        return None
    try:
        return site.accounts.get(ticket.name)
    except Refused:
        return None


def wants_json(request: Request) -> bool:
    """Whether a script asks rather than a browser that shows pages."""
    return "application/json" in request.headers.get("accept", "")


def sign_in_cookie(site: Site, answer: Response, name: str, secure: bool) -> None:
    """Give a browser its sign-in."""
    answer.set_cookie(
        COOKIE, site.seal.issue(name), max_age=LIFETIME_S, httponly=True, samesite="strict", secure=secure
    )


async def form_of(request: Request) -> dict[str, str]:
    """Text fields of a form; files are not taken."""
    async with request.form(max_files=0, max_fields=40) as sent:
        return {name: value for name, value in sent.multi_items() if isinstance(value, str)}


def _looked_at(request: Request, answer: Answer, verb: Verb) -> Response:
    site: Site = request.app.state.site
    ticket = ticket_of(site, request)
    account = account_of(site, ticket)
    if ticket is None or account is None:
        return _not_signed_in(request)
    visit = Visit(site, request, account, ticket, {})
    try:
        site.clinic.accounts.require(account, verb)
    except Refused as refusal:
        return _refused_page(visit, refusal, 403)
    try:
        return answer(visit)
    except REFUSALS as refusal:
        return _refused_page(visit, refusal, 404)


def _acted_on(request: Request, form: Mapping[str, str], answer: Answer, verb: Verb, back: str) -> Response:
    site: Site = request.app.state.site
    ticket = ticket_of(site, request)
    account = account_of(site, ticket)
    if ticket is None or account is None:
        return _not_signed_in(request)
    token = request.headers.get("x-form-token", "") or form.get("form_token", "")
    visit = Visit(site, request, account, ticket, form)
    if not site.seal.form_token_fits(ticket, token):
        return _refusal(visit, "The form is not of this sign-in: load the page again.", 403, back)
    try:
        site.clinic.accounts.require(account, verb)
    except Refused as refusal:
        return _refusal(visit, _sentence(refusal), 403, back)
    try:
        return answer(visit)
    except REFUSALS as refusal:
        return _refusal(visit, _sentence(refusal), 409, back)


def _not_signed_in(request: Request) -> Response:
    if wants_json(request):
        return JSONResponse({"message": "Nobody is signed in, or the sign-in has expired."}, 401)
    wanted = request.url.path if request.method == "GET" else "/"
    if request.method == "GET" and request.url.query:
        wanted += f"?{request.url.query}"
    return RedirectResponse(f"/sign-in?next={quote(wanted, safe='')}", 303)


def _refusal(visit: Visit, sentence: str, status: int, back: str) -> Response:
    if wants_json(visit.request):
        return JSONResponse({"message": sentence}, status)
    if status == 403:
        return visit.page("refused.html.j2", status=status, sentence=sentence)
    return visit.go(back, sentence, good=False)


def _refused_page(visit: Visit, refusal: Refused | RobotRefused, status: int) -> Response:
    return visit.page("refused.html.j2", status=status, sentence=_sentence(refusal))


def _sentence(refusal: Refused | RobotRefused) -> str:
    text = str(refusal)
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
