"""What was sent after the sign-in had ended, shown to its sender to send it now."""

from __future__ import annotations

from starlette.responses import RedirectResponse, Response

from rehab_app.web.kept_forms import KeptForm
from rehab_app.web.presence import take_cookie
from rehab_app.web.stop import is_local
from rehab_app.web.visit import KEPT, Visit

_LONG = 60


def kept(visit: Visit) -> Response:
    """The form again, filled; without one, the start."""
    form = _form(visit)
    if form is None:
        answer = RedirectResponse("/", 303)
        take_cookie(answer, KEPT, visit.request)
        return answer
    fields = [
        (name, name.replace("_", " ").capitalize(), value, len(value) > _LONG or "\n" in value)
        for name, value in form.fields
    ]
    back = form.back if is_local(form.back) else "/"
    return visit.page("kept.html.j2", fields=fields, target=form.path, back=back)


def drop(visit: Visit) -> Response:
    """Forget it; ``action`` has done so already."""
    return visit.go("/", "")


def _form(visit: Visit) -> KeptForm | None:
    return visit.site.kept_forms.find(visit.request.cookies.get(KEPT, ""), visit.account.name)
