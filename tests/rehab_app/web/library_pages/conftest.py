"""A clinic whose library is read and whose forms are sent; a take of a patient where one is asked for."""

from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.web import create_app

from ..conftest import ATTACK, PASSWORD, NoPictures

ITEM = {
    "key": "0",
    "exercise": "pinch",
    "part": "task",
    "mode": "assistive",
    "speed": "50",
    "repetitions": "20",
    "minutes": "8,5",
    "hold_s": "1",
    "warm_up": "2",
    "support": "as-needed",
    "stiffness": "3",
    "resistance": "30",
    "remark": "",
    "reason": "",
    "version": "0",
}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """A clinic of its own."""
    with open_clinic(tmp_path_factory.mktemp("library")) as opened:
        for role in ("therapist", "assistant", "auditor", "patient"):
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        yield opened


@pytest.fixture(scope="module")
def app(library):
    return create_app(library, open_viewports=lambda _: NoPictures())


@pytest.fixture
def someone(library):
    return library.patients.add(
        CONSOLE, given_name="Eva", family_name="Lind", birth_date="1960-02-29", side="right"
    ).id


@pytest.fixture(scope="module")
def recorded(library):
    """A take of a patient's sound hand, made only in a module that asks for it: that takes seconds."""
    person = library.patients.add(
        CONSOLE, given_name=ATTACK, family_name="Weber", birth_date="1957-03-14", side="left"
    )
    asked = RecordingRequest(exercise="open_close", side="right", seconds=3.0, person=person.id)
    library.takes.record(asked, CONSOLE)
    return next(row for row in library.takes.list() if not row.parent)
