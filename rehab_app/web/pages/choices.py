"""What lists offer for choice: a few patients or takes, and more of them by what is typed."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from starlette.responses import JSONResponse, Response

from rehab_app.services.patients import FOR_CHOICE
from rehab_app.services.rows import TakeRow
from rehab_app.web.language import _, written
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.render import day, exercise, moment
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient, TakeFilter, TakeWord
from sessions.catalogue.search import folded, words_of
from sessions.records import SIDES


@dataclass(frozen=True, slots=True)
class Choice:
    """Somebody or something that a list offers.

    Attributes:
        id: Its id.
        shown: Its line in the list.
        name: What it is called where it is searched.
        more: What tells it apart from others of the same name.
        data: What the page's script must know of it, by name.
    """

    id: str
    shown: str
    name: str
    more: str
    data: dict[str, str]


@dataclass(frozen=True, slots=True)
class Choices:
    """What a list offers.

    Attributes:
        rows: At most 20, and the one that is chosen already.
        total: How many there are to be found.
    """

    rows: tuple[Choice, ...]
    total: int

    @property
    def searched(self) -> bool:
        """Whether there are more than a list shows, so that a field to search them is needed."""
        return self.total > FOR_CHOICE


def patient_choices(visit: Visit, typed: str = "", kept: str = "") -> Choices:
    """Patients to choose from; without words those whom somebody works with."""
    found = visit.site.clinic.patients.choice(typed, kept)
    return Choices(tuple(_patient(one) for one in found.patients), found.total)


def take_choices(visit: Visit, typed: str = "", kept: str = "", exercise: str = "") -> Choices:
    """Approved takes to choose from, the newest first."""
    wanted = TakeFilter(exercise=exercise, words=take_words(visit, typed))
    found = visit.site.clinic.takes.shelf.choice(wanted, kept)
    return Choices(tuple(_take(row) for row in found.takes), found.total)


def patients(visit: Visit) -> Response:
    """The patients that were searched for, for a page's script."""
    return _answer(patient_choices(visit, _asked(visit, "find")))


def takes(visit: Visit) -> Response:
    """The approved takes that were searched for; ``take`` asks for one besides, approved or not."""
    found = take_choices(visit, *(_asked(visit, name) for name in ("find", "keep", "exercise")))
    named = _asked(visit, "take")
    row = visit.site.clinic.takes.shelf.named(catalogue_id(named)) if named else None
    besides = None if row is None else {"id": row.id, "approved_by": row.approved_by}
    return _answer(found, take=besides)


def take_words(visit: Visit, typed: str) -> tuple[TakeWord, ...]:
    """Words that were typed, each with the exercises and sides that are called so on the page."""
    words = words_of(typed)
    if not words:
        return ()
    named = {name: folded(exercise(name)) for name in visit.site.clinic.takes.shelf.counts()}
    sides = {side: folded(_(side)) for side in SIDES}
    return tuple(
        TakeWord(
            word,
            tuple(name for name, words in named.items() if word in words),
            tuple(side for side, words in sides.items() if words.startswith(word)),
        )
        for word in words
    )


def take_shown(row: TakeRow) -> str:
    """A take in one line: exercise, side, length, id."""
    return f"{take_name(row)} ({row.id[:8]})"


def take_name(row: TakeRow) -> str:
    """Exercise, side and length of a take."""
    return f"{exercise(row.exercise)}, {_(row.side)}, {written(row.duration_s, 1)} s"


def _answer(found: Choices, **more: object) -> Response:
    return JSONResponse({"rows": [asdict(row) for row in found.rows], "total": found.total, **more})


def _asked(visit: Visit, name: str) -> str:
    return visit.request.query_params.get(name, "").strip()[:160]


def _patient(one: Patient) -> Choice:
    born, side = f"{_('born')} {day(one.birth_date)}", _(one.side)
    name = f"{one.given_name} {one.family_name}".strip() or one.id
    return Choice(
        one.id,
        f"{one.family_name or one.id}, {one.given_name} ({day(one.birth_date)}, {side})",
        name,
        f"{born}, {side}",
        {"name": name, "born": born, "side": one.side, "who": f"{name}, {born}, {side.upper()}"},
    )


def _take(row: TakeRow) -> Choice:
    return Choice(row.id, take_shown(row), take_name(row), moment(row.created_utc_ns), {})
