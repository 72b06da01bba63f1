"""The choice of a language; nobody needs to be signed in for it."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import RedirectResponse, Response

from rehab_app.web.language import COOKIE, LANGUAGES, SOURCE
from rehab_app.web.presence import give_cookie
from rehab_app.web.stop import is_local
from rehab_app.web.visit import form_of

_YEAR_S = 365 * 24 * 3600


async def choose(request: Request) -> Response:
    """Remember a language in this browser and go back."""
    form = await form_of(request)
    back, language = form.get("back", ""), form.get("language", "")
    answer = RedirectResponse(back if is_local(back) else "/", 303)
    give_cookie(answer, COOKIE, language if language in LANGUAGES else SOURCE, _YEAR_S, request)
    return answer
