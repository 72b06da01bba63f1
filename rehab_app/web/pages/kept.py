"""What was sent after the sign-in had ended, shown to its sender to send it now."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.responses import RedirectResponse, Response

from rehab_app.web.kept_forms import KeptForm
from rehab_app.web.language import _, marked
from rehab_app.web.presence import take_cookie
from rehab_app.web.stop import is_local
from rehab_app.web.visit import KEPT, Visit

_LONG = 60
_UNSEEN = ("back", "corrects", "key", "next", "proposal", "since", "username", "version")
"""Fields that a page fills in, no person."""
_WORDS = {
    "birth_date": marked("Birth date"),
    "diagnosis": marked("Diagnosis"),
    "done": marked("What was done"),
    "event_date": marked("Date of the event"),
    "family_name": marked("Family name"),
    "given_name": marked("Given name"),
    "goal": marked("Goal, in the patient's words where possible"),
    "hand_length": marked("Hand length, cm"),
    "happened": marked("What happened"),
    "impairment": marked("Impairment and precautions"),
    "measure": marked("Measure"),
    "measured_on": marked("Measured on"),
    "place": marked("Where"),
    "reason": marked("Reason"),
    "remark": marked("Remark"),
    "repetitions": marked("Repetitions"),
    "score": marked("Score"),
    "sessions_per_week": marked("Sessions a week"),
    "severity": marked("Severity"),
    "side": marked("Affected hand"),
    "text": marked("What should be known"),
    "value": marked("Value"),
    "when": marked("When"),
}


@dataclass(frozen=True, slots=True)
class ShownField:
    """A field of a kept form.

    Attributes:
        name: Of the field.
        words: Its label.
        value: What was typed.
        unseen: Whether it is sent again without being shown: empty, or of no meaning to a person.
        long: Whether it needs several lines.
    """

    name: str
    words: str
    value: str
    unseen: bool
    long: bool


def kept(visit: Visit) -> Response:
    """The form again, filled; without one, the start."""
    form = _form(visit)
    if form is None:
        answer = RedirectResponse("/", 303)
        take_cookie(answer, KEPT, visit.request)
        return answer
    fields = [_shown(name, value) for name, value in form.fields]
    back = form.back if is_local(form.back) else "/"
    return visit.page("kept.html.j2", fields=fields, target=form.path, back=back)


def _shown(name: str, value: str) -> ShownField:
    words = _(_WORDS[name]) if name in _WORDS else name.replace("_", " ").capitalize()
    unseen = not value.strip() or name in _UNSEEN or name.startswith("was")
    return ShownField(name, words, value, unseen, len(value) > _LONG or "\n" in value)


def drop(visit: Visit) -> Response:
    """Forget it; ``action`` has done so already."""
    return visit.go("/", "")


def _form(visit: Visit) -> KeptForm | None:
    return visit.site.kept_forms.find(visit.request.cookies.get(KEPT, ""), visit.account.name)
