"""What holds for the whole clinic: its name and language, the idle lock, retention, the aim of success."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.presentation import LONGEST_NAME
from rehab_app.web.language import LANGUAGES, _, marked, written
from rehab_app.web.pages.asked import not_overtaken, number, whole
from rehab_app.web.pages.typed import sentence_of
from rehab_app.web.visit import Visit

PAGE = "/clinic/settings"


@dataclass(frozen=True, slots=True)
class _Kind:
    """A setting of the page.

    Attributes:
        now: How it stands, as its field shows it.
        change: Reads the field "value" and keeps it.
        said: What is said when it was kept.
    """

    now: Callable[[Clinic], str]
    change: Callable[[Visit], object]
    said: str


def _set_name(visit: Visit) -> None:
    visit.site.clinic.presentation.set_name(visit.account, visit.asked("value"))


def _set_language(visit: Visit) -> None:
    visit.site.clinic.presentation.set_language(visit.account, visit.asked("value"), tuple(LANGUAGES))


def _set_idle(visit: Visit) -> None:
    minutes = whole(visit, "value", "minutes until an idle page is covered")
    visit.site.clinic.accounts.set_idle_lock(minutes, visit.account)


def _set_retention(visit: Visit) -> None:
    visit.site.clinic.privacy.retention.set_years(visit.account, whole(visit, "value", "retention"))


def _set_aim(visit: Visit) -> None:
    percent = number(visit, "value", "aim of success", "a number of percent, such as 70")
    visit.site.clinic.proposals.set_target(visit.account, percent / 100.0)


KINDS = {
    "name": _Kind(lambda clinic: clinic.presentation.name(), _set_name, marked("The clinic's name is set.")),
    "language": _Kind(
        lambda clinic: clinic.presentation.language(), _set_language, marked("The language is set.")
    ),
    "idle": _Kind(
        lambda clinic: f"{clinic.accounts.sign_ins.idle_s() // 60}",
        _set_idle,
        marked("The time was changed."),
    ),
    "retention": _Kind(
        lambda clinic: f"{clinic.privacy.retention.years()}",
        _set_retention,
        marked("The retention is changed. Nothing is erased by itself."),
    ),
    "aim": _Kind(
        lambda clinic: written(round(100 * clinic.proposals.target(), 2)), _set_aim, marked("The aim is set.")
    ),
}


def settings(visit: Visit) -> Response:
    """The page."""
    return _shown(visit, "", "")


def change(kind: str) -> Callable[[Visit], Response]:
    """The answer to the form of one setting.

    A form that was made before somebody else changed the setting is shown again with both values.
    """
    asked = KINDS[kind]

    def answer(visit: Visit) -> Response:
        try:
            not_overtaken(visit, "setting", asked.now(visit.site.clinic), visit.asked("value"))
            asked.change(visit)
        except Refused as refusal:
            return _shown(visit, kind, sentence_of(refusal))
        return visit.go(PAGE, _(asked.said))

    return answer


def _shown(visit: Visit, refused: str, problem: str) -> Response:
    """The page; the form that was refused holds what was typed."""
    now = {name: kind.now(visit.site.clinic) for name, kind in KINDS.items()}
    return visit.page(
        "settings.html.j2",
        status=409 if refused else 200,
        now=now,
        typed={**now, **({refused: visit.asked("value")} if refused else {})},
        problems={refused: problem} if refused else {},
        longest_name=LONGEST_NAME,
    )
