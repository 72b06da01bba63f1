"""The page on which markers are named: who sees it, what it shows, and what becomes of the names."""

from __future__ import annotations

import re

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.web import create_app
from sessions.records.topics import MARKERS
from sessions.store import SessionReader

from .conftest import PASSWORD, NoPictures


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    """A clinic of its own: the takes made here are nobody else's."""
    with open_clinic(tmp_path_factory.mktemp("named")) as opened:
        for role in ("therapist", "auditor"):
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        yield opened


@pytest.fixture(scope="module")
def app(clinic):
    return create_app(clinic, open_viewports=lambda _: NoPictures())


def recorded(clinic, *, consent):
    request = RecordingRequest(
        exercise="open_close", side="right", seconds=1.5, seed=6, consent_images=consent
    )
    return clinic.takes.record(request, CONSOLE).take


@pytest.fixture(scope="module")
def pictured(clinic):
    """A take with pictures."""
    return recorded(clinic, consent=True)


@pytest.fixture(scope="module")
def take_without_pictures(clinic):
    return recorded(clinic, consent=False)


def rings(page):
    return [(float(u), float(v)) for u, v in re.findall(r'data-u="([\d.]+)" data-v="([\d.]+)"', page)]


def first_names(clinic, take):
    """The names that the take's own tracker gave in its first frame, as the page's script sends them."""
    with SessionReader(clinic.takes.get(take).path) as reader:
        first = next(reader.records(MARKERS))
        pairs = zip(reader.header.marker_names, first.pixel_px.tolist(), strict=True)
        return " ".join(f"{name}={u:.1f},{v:.1f}" for name, (u, v) in pairs if u == u)


def test_the_page_shows_the_picture_its_rings_and_the_names(browser, pictured):
    visitor = browser("therapist")
    assert f"/takes/{pictured}/names" in visitor.get(f"/takes/{pictured}").text
    page = visitor.get(f"/takes/{pictured}/names").text
    assert len(rings(page)) >= 20
    assert 'data-name="index_pip"' in page
    assert "/static/names.js" in page
    assert not re.search(r"<script>|style=|onclick", page)
    picture = visitor.get(f"/takes/{pictured}/first.jpg")
    assert picture.headers["content-type"] == "image/jpeg"
    assert picture.headers["cache-control"] == "no-store"


def test_names_make_a_take_that_is_shown(browser, clinic, pictured):
    before = len(clinic.takes.list())
    visitor = browser("therapist")
    answer = visitor.ask(f"/takes/{pictured}/names", labels=first_names(clinic, pictured))
    assert answer.status_code == 200, answer.text
    said = answer.json()
    assert f"Take {pictured} stays as it was" in said["message"]
    assert len(clinic.takes.list()) == before + 1
    shown = visitor.get(said["path"]).text
    assert "was tracked again from" in shown
    assert "in the take that it was tracked from" in shown
    assert clinic.takes.approval(said["path"].rsplit("/", 1)[1]) is None


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        ("", "no named markers"),
        ("index_pip", "NAME=U,V"),
        ("index_pip=1;2", "NAME=U,V"),
        ("index_pip=nan,2", "NAME=U,V"),
        ("sixth_pip=1,2", "one of "),
        ("index_pip=1,2 index_pip=3,4", "each marker once"),
        ("index_pip=640,2", "inside the picture of 640 x 480 px"),
        ("index_pip=10,20", "4 or more"),
    ],
)
def test_wrong_names_are_one_sentence(browser, clinic, pictured, labels, words):
    before = len(clinic.takes.list())
    answer = browser("therapist").ask(f"/takes/{pictured}/names", labels=labels)
    assert answer.status_code == 409
    assert words in answer.json()["message"]
    assert len(clinic.takes.list()) == before


def test_a_take_without_pictures_says_why_not_and_has_no_link(browser, take_without_pictures):
    visitor = browser("therapist")
    shown = visitor.get(f"/takes/{take_without_pictures}").text
    assert "record with consent to images" in shown
    assert f"/takes/{take_without_pictures}/names" not in shown
    page = visitor.get(f"/takes/{take_without_pictures}/names")
    assert page.status_code == 200
    assert "record with consent to images" in page.text
    assert visitor.get(f"/takes/{take_without_pictures}/first.jpg").status_code == 404


@pytest.mark.parametrize("role", ["auditor", None])
def test_pictures_are_for_those_who_may_record(browser, pictured, role):
    visitor = browser(role)
    for path in (f"/takes/{pictured}/names", f"/takes/{pictured}/first.jpg"):
        assert visitor.get(path).status_code == (403 if role else 303)
    assert visitor.ask(f"/takes/{pictured}/names", labels="a=1,2").status_code == (403 if role else 401)


def test_the_form_token_of_this_sign_in_is_asked_for(browser, pictured):
    visitor = browser("therapist")
    visitor.token = "guess"
    assert visitor.ask(f"/takes/{pictured}/names", labels="a=1,2").status_code == 403
