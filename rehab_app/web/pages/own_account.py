"""One's own account: the password, and where one is signed in."""

from __future__ import annotations

from starlette.responses import RedirectResponse, Response

from rehab_app.errors import Refused
from rehab_app.web.language import _
from rehab_app.web.presence import COOKIE, sign_in_cookie, take_cookie
from rehab_app.web.visit import Visit

PAGE = "/account"


def account(visit: Visit) -> Response:
    """The page."""
    return _shown(visit, "")


def change_password(visit: Visit) -> Response:
    """Change it: every sign-in of the account ends, and this browser gets a new one."""
    new = visit.form.get("new_password", "")
    if new != visit.form.get("again_password", ""):
        return _shown(visit, _("The two passwords differ: type the same one twice."))
    try:
        with visit.site.signing_in:
            visit.site.clinic.accounts.change_password(visit.account, visit.form.get("old_password", ""), new)
    except Refused as refusal:
        return _shown(visit, str(refusal))
    answer = visit.go(PAGE, _("The password was changed. Everywhere else you were signed out."))
    sign_in_cookie(visit.site, answer, visit.account.name, visit.request)
    return answer


def sign_out_everywhere(visit: Visit) -> Response:
    """End every sign-in of the account, this one too."""
    visit.site.clinic.accounts.sign_ins.end_all(visit.account.name)
    visit.site.clinic.audit.note_later(visit.account.name, "sign out", "", "everywhere")
    answer = RedirectResponse("/sign-in", 303)
    take_cookie(answer, COOKIE, visit.request)
    return answer


def _shown(visit: Visit, sentence: str) -> Response:
    held = visit.site.clinic.catalogue.sign_ins(visit.account.name)
    status = 409 if sentence else 200
    return visit.page("account.html.j2", status=status, sentence=sentence, held=held, own=visit.ticket.digest)
