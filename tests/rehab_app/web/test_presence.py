"""Sign-ins that the server remembers: ended everywhere, covered when idle; what was typed is kept."""

from __future__ import annotations

import re

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.sign_ins import IDLE_S, LIFETIME_S
from rehab_app.web import create_app
from rehab_app.web.presence import COOKIE

from .conftest import PASSWORD, Browser, NoPictures

SECOND_NS = 1_000_000_000
NEW = "another long sentence"


class Clock:
    def __init__(self):
        self.now_ns = 1_900_000_000 * SECOND_NS

    def __call__(self):
        return self.now_ns

    def wait(self, seconds):
        self.now_ns += round(seconds * SECOND_NS)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def own(tmp_path, clock, monkeypatch):
    """A clinic of its own whose sign-ins run on a clock that only the test moves."""
    monkeypatch.setattr("rehab_app.services.accounts.hash_password", lambda password: f"hash {password}")
    monkeypatch.setattr(
        "rehab_app.services.accounts.verify_password", lambda kept, password: kept == f"hash {password}"
    )
    with open_clinic(tmp_path) as opened:
        on_clock(opened, clock)
        for name, role in (("ada", "administrator"), ("tom", "therapist"), ("pia", "patient")):
            opened.accounts.add_user(name, role, PASSWORD, CONSOLE)
        yield opened


def on_clock(clinic, clock):
    clinic.catalogue._clock_ns = clock
    clinic.accounts.sign_ins._clock_ns = clock


@pytest.fixture
def visit(own):
    app = create_app(own, open_viewports=lambda _: NoPictures())
    return lambda role=None: Browser(app, role)


def signed_in(visitor):
    return visitor.get("/account").status_code == 200


def test_a_sign_in_survives_a_restart_and_ends_after_its_time(own, visit, clock):
    tom = visit("tom")
    again = Browser(create_app(own, open_viewports=lambda _: NoPictures()))
    again.cookies = tom.cookies
    own.accounts.sign_ins._known.clear()
    assert signed_in(again)
    for _ in range(LIFETIME_S // 600 - 1):
        clock.wait(600)
        assert signed_in(tom)
    clock.wait(601)
    assert not signed_in(tom)


@pytest.mark.parametrize("how", ["password", "role", "close", "reset", "everywhere"])
def test_what_ends_a_sign_in_ends_all_of_that_person_at_once(own, visit, how):
    first, second, other = visit("tom"), visit("tom"), visit("ada")
    ada = own.accounts.account("ada")
    if how == "password":
        fields = {"old_password": PASSWORD, "new_password": NEW, "again_password": NEW}
        assert first.post("/account/password", **fields).status_code == 303
        assert signed_in(first)  # this browser got a new sign-in
    elif how == "role":
        own.accounts.change_role("tom", "assistant", ada)
    elif how == "close":
        own.accounts.close("tom", ada)
    elif how == "reset":
        own.accounts.reset_password("tom", NEW, ada)
    else:
        first.post("/account/sign-out")
    assert not signed_in(second)
    assert signed_in(other)


def test_another_process_ends_a_sign_in_within_seconds(own, visit, clock):
    tom = visit("tom")
    own.catalogue.end_sign_ins("tom")
    clock.wait(2.1)
    assert not signed_in(tom)


def test_a_sign_in_gets_a_new_secret_and_ends_the_one_before(own, visit):
    fixed = visit("tom")
    stolen = fixed.cookies[COOKIE]
    fixed.post("/sign-in", name="tom", password=PASSWORD)
    assert fixed.cookies[COOKIE] != stolen
    thief = visit()
    thief.cookies.set(COOKIE, stolen)
    assert not signed_in(thief)
    assert stolen not in str(own.catalogue.sign_ins("tom"))


def test_an_idle_page_is_locked_and_the_same_password_goes_on(own, visit, clock):
    tom = visit("tom")
    clock.wait(IDLE_S - 1)
    assert signed_in(tom)
    clock.wait(IDLE_S + 1)
    assert tom.get("/here").json()["state"] == "locked"
    assert tom.ask("/account/sign-out").status_code == 423
    assert "password" in tom.get("/sign-in").text
    assert 'value="tom"' in tom.get("/sign-in").text
    assert tom.ask("/unlock", name="tom", password="wrong").status_code == 403
    assert tom.ask("/unlock", name="ada", password=PASSWORD).status_code == 403
    assert tom.get("/here").json()["state"] == "locked"
    answer = tom.ask("/unlock", name="tom", password=PASSWORD)
    assert answer.json()["token"] == tom.token
    assert signed_in(tom)


def test_the_heartbeat_is_no_use_and_goes_on_under_the_cover(own, visit, clock):
    tom = visit("tom")
    for _ in range(IDLE_S // 100 + 1):
        clock.wait(100)
        assert tom.ask("/live/beat", page="p").status_code == 200
        tom.get("/here")
    assert tom.get("/here").json()["state"] == "locked"
    assert tom.ask("/live/beat", page="p").status_code == 200
    assert tom.ask("/live/resume").status_code == 423


def test_typing_counts_as_use(own, visit, clock):
    tom = visit("tom")
    for _ in range(4):
        clock.wait(IDLE_S / 2)
        assert tom.ask("/here").status_code == 200
    assert signed_in(tom)


def test_the_stop_works_on_a_covered_page_and_asks_no_data_base(own, visit, clock, monkeypatch):
    tom = visit("tom")
    clock.wait(IDLE_S + 1)

    def broken(*_):
        raise AssertionError("the stop asked the data base")

    monkeypatch.setattr(own.catalogue, "sign_in", broken)
    monkeypatch.setattr(own.accounts.sign_ins, "look", broken)
    assert tom.ask("/stop").status_code == 200
    assert own.live.snapshot().stop_source == "tom"


def test_every_page_has_the_cover_but_not_the_patients(own, visit):
    page = visit("tom").get("/account").text
    assert 'id="cover"' in page
    assert f'data-idle-s="{IDLE_S}"' in page
    assert 'id="cover"' not in visit("pia").get("/mine").text


def test_the_patients_screen_stays_and_shows_only_its_own(own, visit, clock):
    pia = visit("pia")
    clock.wait(IDLE_S + 1)
    page = pia.get("/mine")
    assert page.status_code == 200
    assert "/live/pain" in page.text
    assert 'id="stop-button"' in page.text
    assert "/patients" not in page.text
    assert pia.get("/").headers["location"] == "/mine"
    assert set(pia.get("/mine/state").json()) == {"name", "exercise", "step", "going", "count"}


def test_a_form_that_came_too_late_comes_back_filled(own, visit, clock):
    tom = visit("tom")
    text = "Ünïcode & <b>\nsecond line " + "x" * 10_000
    clock.wait(LIFETIME_S + 1)
    late = tom.post("/patients/P-0001/journal/note", text=text, password_hint="")
    assert "password" not in late.text
    late = tom.post("/patients/P-0001/journal/note", text=text)
    assert late.headers["location"] == "/sign-in?next=%2Fkept"
    assert "kept" in tom.get("/sign-in?next=/kept").text
    answer = tom.post("/sign-in", name="tom", password=PASSWORD, next="/kept")
    assert answer.headers["location"] == "/kept"
    page = tom.get("/kept").text
    assert 'action="/patients/P-0001/journal/note"' in page
    assert "&lt;b&gt;\nsecond line" in page
    assert "x" * 10_000 in page
    tom.token = re.search('data-token="([^"]+)"', page).group(1)
    assert tom.post("/kept/drop").status_code == 303
    assert tom.get("/kept").headers["location"] == "/"


def test_what_one_person_typed_is_not_shown_to_another(own, visit, clock):
    tom = visit("tom")
    clock.wait(LIFETIME_S + 1)
    tom.post("/patients", given_name="Somebody", birth_date="1950-01-01")
    tom.post("/sign-in", name="ada", password=PASSWORD, next="/kept")
    assert tom.get("/kept").headers["location"] == "/"


def test_a_form_with_a_password_is_never_kept(own, visit, clock):
    ada = visit("ada")
    clock.wait(LIFETIME_S + 1)
    late = ada.post("/clinic/users", name="new", role="therapist", password=NEW, again=NEW)
    assert "kept" not in late.headers["location"]
    assert NEW not in repr(ada.app.state.site.kept_forms._forms)
