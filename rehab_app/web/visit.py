"""One request of somebody: who they are, what they sent, and how they are answered."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias
from urllib.parse import quote, urlsplit

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from rehab_app.access import Account, Verb
from rehab_app.errors import REFUSALS, NoAnswer, Refused, RobotRefused
from rehab_app.web.language import _
from rehab_app.web.presence import COOKIE, Present, give_cookie, present
from rehab_app.web.refusals import sentence_of
from rehab_app.web.render import render
from rehab_app.web.signing import Ticket
from rehab_app.web.site import Site

NOTICE = "rehab_notice"
KEPT = "rehab_kept"
_KEPT_S = 1800
# The heartbeat is nobody's doing: it neither keeps a page from being covered nor ends with it.
QUIET = frozenset(("/live/beat",))
LOCKED = 423
_SUBJECTS = ("patient", "recording")
_LISTS = frozenset(("/patients", "/takes", "/sessions", "/live/patients"))
_LONGEST_PATH, _LONGEST_SUBJECT = 120, 40


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
        give_cookie(answer, NOTICE, self.site.seal.notice(notice, good), 60, self.request)


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


def wants_json(request: Request) -> bool:
    """Whether a script asks rather than a browser that shows pages."""
    return "application/json" in request.headers.get("accept", "")


async def form_of(request: Request) -> dict[str, str]:
    """Text fields of a form; files are not taken."""
    async with request.form(max_files=0, max_fields=40) as sent:
        return {name: value for name, value in sent.multi_items() if isinstance(value, str)}


def _looked_at(request: Request, answer: Answer, verb: Verb) -> Response:
    site: Site = request.app.state.site
    there = _there(site, request)
    if isinstance(there, Response):
        return there
    visit = Visit(site, request, there.account, there.ticket, {})
    try:
        site.clinic.accounts.require(there.account, verb)
    except Refused as refusal:
        _note_refused(visit)
        return _refused_page(visit, refusal, 403)
    try:
        shown = answer(visit)
    except REFUSALS as refusal:
        return _refused_page(visit, refusal, 503 if isinstance(refusal, NoAnswer) else 404)
    _note_view(visit, shown)
    return shown


def _acted_on(request: Request, form: Mapping[str, str], answer: Answer, verb: Verb, back: str) -> Response:
    site: Site = request.app.state.site
    there = _there(site, request, form)
    if isinstance(there, Response):
        return there
    token = request.headers.get("x-form-token", "") or form.get("form_token", "")
    visit = Visit(site, request, there.account, there.ticket, form)
    if not site.seal.form_token_fits(there.ticket, token):
        _note_refused(visit)
        return _refusal(visit, _("The form is not of this sign-in: load the page again."), 403, back)
    try:
        site.clinic.accounts.require(there.account, verb)
    except Refused as refusal:
        _note_refused(visit)
        return _refusal(visit, sentence_of(refusal), 403, back)
    site.kept_forms.drop(request.cookies.get(KEPT, ""))
    try:
        return answer(visit)
    except REFUSALS as refusal:
        return _refusal(visit, sentence_of(refusal), 409, back)


def _there(site: Site, request: Request, form: Mapping[str, str] | None = None) -> Present | Response:
    """Who asks, or the answer to somebody who is not signed in or whose sign-in is locked."""
    there, quiet = present(site, request), request.url.path in QUIET
    if there is None or (there.locked and not quiet):
        return _not_signed_in(site, request, form or {}, locked=there is not None)
    if not quiet:
        site.clinic.accounts.sign_ins.touch(there.ticket.digest)
    return there


def _not_signed_in(site: Site, request: Request, form: Mapping[str, str], *, locked: bool) -> Response:
    if wants_json(request):
        if locked:
            return JSONResponse({"message": _("This page is locked: give your password again.")}, LOCKED)
        return JSONResponse({"message": _("Nobody is signed in, or the sign-in has expired.")}, 401)
    wanted = request.url.path if request.method == "GET" else "/"
    if request.method == "GET" and request.url.query:
        wanted += f"?{request.url.query}"
    key = _kept(site, request, form)
    answer = RedirectResponse(f"/sign-in?next={quote('/kept' if key else wanted, safe='')}", 303)
    if key:
        give_cookie(answer, KEPT, key, _KEPT_S, request)
    return answer


def _kept(site: Site, request: Request, form: Mapping[str, str]) -> str:
    """Keep what was typed for whoever sat here; "" where there was nothing, or nobody knows who that was."""
    owner = site.seal.read_old(request.cookies.get(COOKIE))
    if owner is None or not form:
        return ""
    came_from = urlsplit(request.headers.get("referer", "")).path
    return site.kept_forms.keep(owner.name, request.url.path, came_from, form)


def _note_refused(visit: Visit) -> None:
    path = visit.request.url.path[:_LONGEST_PATH]
    visit.site.clinic.audit.note_later(visit.account.name, "refused", path, visit.request.method)


def _note_view(visit: Visit, shown: Response) -> None:
    """A row for whoever saw somebody's data: a patient, a recording, a report, the list of patients."""
    path, parts = visit.request.url.path, visit.request.path_params
    subject = next((str(parts[name]) for name in _SUBJECTS if name in parts), "")
    picture = path.endswith((".jpg", ".svg"))
    if shown.status_code < 400 and not picture and (subject or path in _LISTS):
        visit.site.clinic.audit.note_view(visit.account, subject[:_LONGEST_SUBJECT], path[:_LONGEST_PATH])


def _refusal(visit: Visit, sentence: str, status: int, back: str) -> Response:
    if wants_json(visit.request):
        return JSONResponse({"message": sentence}, status)
    if status == 403:
        return visit.page("refused.html.j2", status=status, sentence=sentence)
    return visit.go(back, sentence, good=False)


def _refused_page(visit: Visit, refusal: Refused | RobotRefused, status: int) -> Response:
    return visit.page("refused.html.j2", status=status, sentence=sentence_of(refusal))
