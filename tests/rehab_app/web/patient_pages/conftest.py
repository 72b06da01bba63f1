"""A clinic with one patient whose pages are read and whose forms are sent."""

from __future__ import annotations

import html
import re

import pytest

from rehab_app.access import CONSOLE, ROLES
from rehab_app.bootstrap import open_clinic
from rehab_app.web import create_app

from ..conftest import PASSWORD, NoPictures

FORM = {
    "given_name": "Eva",
    "family_name": "Lind",
    "birth_date": "1960-02-29",
    "side": "right",
    "hand_length_cm": "17,5",
    "impairment": "",
}


TABS = ("", "/edit", "/diagnosis", "/limits", "/outcomes", "/journal", "/sessions")


DAY_NS = 86_400_000_000_000


NOTE, PAIN, EVENT = "/journal/note", "/journal/pain", "/journal/event"


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    """A clinic of this module's own: its patients are counted."""
    with open_clinic(tmp_path_factory.mktemp("patients")) as opened:
        for role in ROLES:
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        yield opened


@pytest.fixture(scope="module")
def app(clinic):
    return create_app(clinic, open_viewports=lambda _: NoPictures())


@pytest.fixture
def at(clinic):
    """Path of a patient whom no other test has seen."""
    number = len(clinic.patients.list()) + len(clinic.patients.search(archived=True).patients)
    added = clinic.patients.add(
        CONSOLE,
        given_name="Ada",
        family_name=f"Case{number}",
        birth_date="1957-05-17",
        side="left",
        impairment="first words",
    )
    return f"/patients/{added.id}"


def text_of(answer):
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", answer.text)))


def edit_form(at, clinic, **changed):
    """What a browser sends that opened the form now."""
    patient = clinic.patients.get(at.rsplit("/", 1)[1])
    fields = {
        "given_name": patient.given_name,
        "family_name": patient.family_name,
        "birth_date": patient.birth_date,
        "side": patient.side,
        "hand_length_cm": "18.9",
        "impairment": patient.impairment,
    }
    was = {f"was_{name}": value for name, value in fields.items()}
    return {"version": str(patient.version), **was, **fields, **changed}
