"""The pages of a station whose data base is gone: they say so, the stop works, nobody new comes in."""

from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.web import create_app
from tests.postgres_server import server
from tests.rehab_app.web.conftest import PASSWORD, Browser, NoPictures


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    settings = Settings(catalogue_url=server().fresh(), station="room")
    with open_clinic(tmp_path_factory.mktemp("room"), settings=settings) as clinic:
        clinic.accounts.add_user("anna", "therapist", PASSWORD, CONSOLE)
        clinic.patients.add(
            CONSOLE, given_name="Ida", family_name="Berg", birth_date="1957-03-14", side="left"
        )
        yield clinic


@pytest.fixture(scope="module")
def pages(room):
    """What somebody meets who was signed in when the data base went away, and somebody who was not."""
    app = create_app(room, open_viewports=lambda _: NoPictures())
    anna, stranger = Browser(app, "anna"), Browser(app)
    before = {path: anna.get(path) for path in ("/live", "/patients", "/takes")}
    server().stop()
    try:
        met = {
            "live": anna.get("/live"),
            "in Italian": anna.get("/live", **{"accept-language": "it"}),
            "patients": anna.get("/patients"),
            "pain": anna.ask("/live/pain"),
            "start": stranger.get("/"),
            "sign-in": stranger.get("/sign-in"),
            "signing in": stranger.post("/sign-in", name="anna", password=PASSWORD),
            "stop": stranger.post("/stop"),
            "state": stranger.get("/stop/state"),
            "clear": anna.post("/stop/clear", looked="yes", back="/live"),
        }
        room.audit.note(CONSOLE, "meanwhile")
        met["then"] = anna.get("/live")
    finally:
        server().start()
    return before, met


def test_nothing_is_said_while_all_is_well(pages):
    before, _ = pages
    assert {answer.status_code for answer in before.values()} == {200}
    assert not any("does not answer" in answer.text for answer in before.values())


def test_the_live_page_goes_on_and_says_how_much_waits(pages):
    _, met = pages
    assert met["live"].status_code == 200, met["live"].text
    assert "The catalogue does not answer; recording goes on" in met["then"].text
    assert "Il catalogo non risponde" in met["in Italian"].text


def test_a_page_that_cannot_be_shown_says_why_in_one_sentence(pages):
    _, met = pages
    assert met["patients"].status_code in (404, 503)
    assert "not answering" in met["patients"].text
    assert "The catalogue does not answer" in met["patients"].text
    assert "Traceback" not in met["patients"].text


def test_nobody_new_comes_in(pages, room):
    _, met = pages
    assert met["signing in"].status_code in (403, 503)
    assert "not answering" in met["signing in"].text
    assert met["start"].status_code < 500 or "not answering" in met["start"].text


def test_stop_and_pain_work(pages):
    _, met = pages
    assert met["stop"].status_code < 400
    assert met["state"].json()["stopped"] is True
    assert met["clear"].status_code == 303
    assert met["pain"].status_code < 400


def test_what_was_done_meanwhile_is_in_the_audit_afterwards(pages, room):
    room.audit.close()
    room.outbox.bring()
    verbs = [row.verb for row in room.catalogue.audit()]
    assert {"stop", "clear stop", "meanwhile"} <= set(verbs)
    room.catalogue.verify_audit()
