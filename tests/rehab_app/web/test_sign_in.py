"""Sign-in, tickets, the first account."""

from __future__ import annotations

import stat
import time

import pytest

from rehab_app.bootstrap import open_clinic
from rehab_app.web import create_app
from rehab_app.web.signing import LIFETIME_S, Seal, clinic_key
from rehab_app.web.visit import COOKIE

from .conftest import PASSWORD, NoPictures


def test_right_password_signs_in_with_a_guarded_cookie(browser):
    visitor = browser()
    answer = visitor.post("/sign-in", name="therapist", password=PASSWORD, next="/takes")
    assert (answer.status_code, answer.headers["location"]) == (303, "/takes")
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert visitor.get("/takes").status_code == 200


@pytest.mark.parametrize(("name", "password"), [("therapist", "wrong"), ("nobody", PASSWORD), ("", "")])
def test_wrong_names_and_passwords_say_the_same(browser, name, password):
    answer = browser().post("/sign-in", name=name, password=password)
    assert answer.status_code == 403
    assert "check both and try again" in answer.text
    assert COOKIE not in answer.headers.get("set-cookie", "")


def test_guessing_is_slowed_down_by_address(clinic, browser):
    app = create_app(clinic, open_viewports=lambda _: NoPictures())
    visitor = browser(app=app, address="192.0.2.99")
    for _ in range(20):
        app.state.site.sign_in_limit.fail(visitor.address)
    answer = visitor.post("/sign-in", name="auditor", password=PASSWORD)
    assert answer.status_code == 403
    assert "wait" in answer.text


@pytest.mark.parametrize(
    "wanted", ["https://evil.example", "//evil.example", "/\\evil.example", "javascript:1"]
)
def test_sign_in_leads_to_this_server_only(browser, wanted):
    answer = browser().post("/sign-in", name="assistant", password=PASSWORD, next=wanted)
    assert answer.headers["location"] == "/"


def test_pages_without_a_sign_in_lead_to_it(browser):
    answer = browser().get("/patients?x=1")
    assert answer.status_code == 303
    assert answer.headers["location"] == "/sign-in?next=%2Fpatients%3Fx%3D1"


def test_signing_out_ends_the_ticket_itself(browser):
    visitor = browser("therapist")
    kept = visitor.cookies[COOKIE]
    assert visitor.post("/sign-out").headers["location"] == "/sign-in"
    visitor.cookies.set(COOKIE, kept)
    assert visitor.get("/patients").status_code == 303


def test_closed_accounts_are_signed_out(app, browser):
    visitor = browser("therapist")
    cookie = app.state.site.begin("somebody who left")
    visitor.cookies.clear()
    visitor.cookies.set(COOKIE, cookie)
    assert visitor.get("/patients").status_code == 303


def test_forged_and_old_tickets_are_worth_nothing(monkeypatch):
    seal = Seal(b"k" * 32)
    cookie = seal.issue("anna")
    assert seal.read(cookie).name == "anna"
    assert seal.read(cookie.swapcase()) is None
    assert seal.read("") is None
    assert Seal(b"x" * 32).read(cookie) is None
    assert seal.read(seal.notice("anna", True)) is None
    now = time.time()
    monkeypatch.setattr("time.time", lambda: now + LIFETIME_S + 2)
    assert seal.read(cookie) is None


def test_the_key_is_private_and_stays(tmp_path):
    path = tmp_path / "secret"
    key = clinic_key(path)
    assert len(key) == 32
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert clinic_key(path) == key


def test_the_first_account_is_made_at_the_server_only(tmp_path, browser):
    fields = {"name": "anna", "password": PASSWORD, "again": PASSWORD}
    with open_clinic(tmp_path) as fresh:
        app = create_app(fresh, open_viewports=lambda _: NoPictures())
        far = browser(app=app)
        assert far.get("/").headers["location"] == "/set-up"
        assert far.post("/set-up", **fields).status_code == 403
        assert fresh.accounts.set_up_needed()
        here = browser(app=app, address="127.0.0.1")
        wrong = here.post("/set-up", **{**fields, "again": "else"})
        assert wrong.status_code == 409
        assert here.post("/set-up", **fields).status_code == 303
        assert fresh.accounts.account("anna").role == "administrator"
        assert here.get("/set-up").headers["location"] == "/sign-in"
        second = here.post("/set-up", **{**fields, "name": "eve"})
        assert second.headers["location"] == "/sign-in"
        assert len(fresh.catalogue.users()) == 1
