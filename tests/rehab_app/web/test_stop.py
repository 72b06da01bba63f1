"""The stop works for anybody, on every page, whatever else is broken; clearing it is a person's decision."""

from __future__ import annotations

import pytest

from rehab_app.access import ROLES

pytestmark = pytest.mark.usefixtures("stop_cleared")
PAGES = ("/live", "/patients", "/patients/new", "/takes", "/sessions", "/takes/none", "/sessions/none")


def stopped(clinic):
    return clinic.live.snapshot().state == "stopped"


def test_anybody_stops_without_a_sign_in(browser, clinic):
    answer = browser().ask("/stop")
    assert answer.json() == {"stopped": True}
    assert stopped(clinic)
    assert clinic.live.snapshot().stop_source == "unnamed"


def test_the_button_works_without_scripts(browser, clinic):
    assert browser().post("/stop").status_code == 303
    assert stopped(clinic)


@pytest.mark.parametrize("role", ROLES)
def test_every_role_stops_and_is_named(browser, clinic, role):
    assert browser(role).ask("/stop").status_code == 200
    assert clinic.live.snapshot().stop_source == role


def test_it_needs_neither_form_token_nor_data_base(browser, clinic, app, monkeypatch):
    def broken(*_):
        raise AssertionError("the stop asked the data base")

    monkeypatch.setattr(clinic.catalogue, "users", broken)
    monkeypatch.setattr(app.state.site.accounts, "get", broken)
    visitor = browser("therapist")
    visitor.token = ""
    assert visitor.ask("/stop").status_code == 200
    assert stopped(clinic)


def test_an_expired_sign_in_still_stops(browser, clinic):
    visitor = browser("therapist")
    visitor.cookies.clear()
    visitor.cookies.set("rehab_sign_in", "expired")
    assert visitor.ask("/stop").status_code == 200
    assert stopped(clinic)


def test_other_sites_cannot_stop(browser, clinic):
    assert browser().post("/stop", origin="https://evil.example").status_code == 403
    assert not stopped(clinic)
    assert browser().post("/stop", origin="").status_code == 303
    assert stopped(clinic)


@pytest.mark.parametrize("path", PAGES)
def test_every_page_shows_the_button_and_the_latched_stop(browser, path):
    before = browser("therapist").get(path).text
    assert before.count('id="stop-button"') == 1
    assert "hardware stop" in before
    assert '<section id="latched" role="alert" hidden>' in before
    browser().ask("/stop")
    after = browser("therapist").get(path).text
    assert "STOPPED. Nothing moves" in after
    assert '<section id="latched" role="alert" >' in after
    assert "I have looked at the patient" in after


def test_the_sign_in_page_shows_it_too(browser):
    assert 'id="stop-button"' in browser().get("/sign-in").text
    browser().ask("/stop")
    page = browser().get("/sign-in").text
    assert 'data-stopped="yes"' in page
    assert "/stop/clear" not in page
    assert browser().get("/stop/state").json() == {"stopped": True}


def test_clearing_needs_the_confirmation(browser, clinic):
    browser().ask("/stop")
    refused = browser("therapist").ask("/stop/clear")
    assert refused.status_code == 409
    assert "looked at the patient" in refused.json()["message"]
    assert stopped(clinic)
    assert browser("therapist").ask("/stop/clear", looked="yes").status_code == 200
    assert not stopped(clinic)


@pytest.mark.parametrize("role", ["assistant", "patient", "auditor"])
def test_clearing_needs_the_role(browser, clinic, role):
    browser().ask("/stop")
    assert browser(role).ask("/stop/clear", looked="yes").status_code == 403
    assert stopped(clinic)


def test_nothing_starts_while_it_is_pressed(browser):
    browser().ask("/stop")
    answer = browser("therapist").ask(
        "/live/record", exercise="open_close", side="right", seconds="2", countdown="0"
    )
    assert answer.status_code == 409
    assert "clear the stop" in answer.json()["message"]


def test_after_clearing_the_browser_stays_on_this_server(browser):
    browser().ask("/stop")
    answer = browser("therapist").post("/stop/clear", looked="yes", back="//evil.example")
    assert answer.headers["location"] == "/"
