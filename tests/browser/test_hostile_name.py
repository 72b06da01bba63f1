"""A patient whose name is a script, a sign-in that ends in mid-form, a page that nobody used for a while."""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import Page, expect

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.sign_ins import IDLE_KEY
from rehab_app.web.language import COOKIE
from sessions.catalogue import Setting

from .conftest import PASSWORD
from .test_clinic import EXPECTED, button, clear_stop, desk, state, until
from .test_two_clinicians import SEALED, UNDRAWN, covered_by_the_stop, play, sign_in

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

ADMINISTRATOR = "ada"
GIVEN, FAMILY = "<img src=x onerror=alert(1)>", "O'Neill\"><svg onload=alert(2)>"
PAGES = (
    "/patients",
    "/patients/{patient}",
    "/patients/{patient}/edit",
    "/patients/{patient}/diagnosis",
    "/patients/{patient}/limits",
    "/patients/{patient}/plan",
    "/patients/{patient}/outcomes",
    "/patients/{patient}/journal",
    "/patients/{patient}/sessions",
    "/patients/{patient}/assessments",
    "/patients/{patient}/data",
    "/patients/{patient}/progress",
    "/patients/{patient}/compare",
    "/patients/{patient}/next",
    "/sessions",
    "/sessions/{session}",
    "/sessions/{session}/report",
    "/live?patient={patient}",
)
NAMELESS = ("/clinic/audit", "/sessions/{session}/report.html")
IDLE_S = 8
NOTE = "Thumb stiff since Monday; splint <not> worn & 3 > 2\nsecond line"


@pytest.fixture(scope="module")
def page(visitor, served):
    """The administrator, who may look at every page."""
    with open_clinic(served.folder) as clinic:
        clinic.accounts.add_user(ADMINISTRATOR, "administrator", PASSWORD, CONSOLE)
        take = clinic.takes.record_virtual("open_close", "right", 4.0, 3, CONSOLE)
        clinic.takes.approve(take.take, CONSOLE)
    opened = visitor()
    opened.context.add_init_script(UNDRAWN)
    sign_in(opened, served.address, ADMINISTRATOR)
    return opened


@pytest.fixture(scope="module")
def ids(page, served):
    """The patient, typed in as a receptionist would, and a session that was played."""
    page.goto(served.address + "/patients/new")
    page.get_by_label("Given name").fill(GIVEN)
    page.get_by_label("Family name").fill(FAMILY)
    page.get_by_label("Birth date").fill("1961-07-02")
    page.get_by_label("Right").check()
    page.get_by_label("Impairment").fill(GIVEN)
    button(page, "Add the patient").click()
    expect(page.get_by_text(f"{GIVEN} {FAMILY} was added.")).to_be_visible()
    patient = page.url.rpartition("/")[2]
    page.goto(f"{served.address}/live?patient={patient}")
    play(page, patient)
    expect(page.locator("#patient")).to_contain_text(f"{GIVEN} {FAMILY}")
    harmless(page)
    page.keyboard.press("Escape")
    expect(page.get_by_text(SEALED)).to_be_visible()
    session = page.locator("[data-link=session]").get_attribute("href").rpartition("/")[2]
    return {"patient": patient, "session": session}


def harmless(page: Page) -> None:
    """Nothing of the name became part of a page, of the pictures in it neither, and nothing of it ran."""
    for frame in page.frames:
        assert frame.locator("img[src=x], svg[onload], [onerror]").count() == 0, frame.url
    assert page.dialogs == []


def test_the_name_is_text_on_every_page_that_shows_it(page, served, ids, look):
    for path in PAGES:
        answer = page.goto(served.address + path.format(**ids))
        assert answer.ok, path
        whole = page.content()
        assert "&lt;img src=x onerror=alert(1)&gt;" in whole or GIVEN in page.locator("body").inner_text(), (
            path
        )
        harmless(page)
    look("60-hostile-live")
    for path in NAMELESS:
        page.goto(served.address + path.format(**ids))
        assert "onerror=alert(1)" not in page.content(), f"{path} names the patient"
        harmless(page)


def test_a_form_that_outlives_its_sign_in_keeps_what_was_typed(page, served, ids, look):
    page.goto(f"{served.address}/patients/{ids['patient']}")
    page.get_by_label("Quick note").fill(NOTE)
    with open_clinic(served.folder) as clinic:
        clinic.accounts.sign_ins.end_all(ADMINISTRATOR)
    here = "async () => (await (await fetch('/here')).json()).state"
    until(page, lambda: page.evaluate(here) == "out", "the sign-in never ended")
    button(page, "^Write$").click()
    expect(page.get_by_text("What you typed is kept.")).to_be_visible()
    look("61-kept")
    page.get_by_label("Name").fill(ADMINISTRATOR)
    page.get_by_label("Password").fill(PASSWORD)
    button(page, "^Sign in$").click()
    expect(page.get_by_role("heading", name="Nothing you typed was lost")).to_be_visible()
    assert page.locator("main textarea").input_value() == NOTE
    look("62-not-sent-yet")
    button(page, "Send it now").click()
    page.goto(f"{served.address}/patients/{ids['patient']}/journal")
    expect(page.get_by_text("splint <not> worn & 3 > 2").first).to_be_visible()


def test_the_stop_is_whole_and_covers_no_link_in_the_longer_language(page, served):
    page.context.add_cookies([{"name": COOKIE, "value": "it", "url": served.address}])
    page.goto(served.address + "/patients")
    for width, height in ((1440, 900), (1024, 768), (768, 1024)):
        page.set_viewport_size({"width": width, "height": height})
        assert covered_by_the_stop(page) == [], (width, height)
        assert page.locator("#stop-button").evaluate("stop => stop.scrollWidth <= stop.clientWidth"), width
    page.context.add_cookies([{"name": COOKIE, "value": "en", "url": served.address}])
    page.set_viewport_size({"width": 1440, "height": 900})


def test_an_idle_page_is_covered_while_the_hand_moves_on_and_its_stop_works(page, served, ids, look):
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(f"{served.address}/live?patient={ids['patient']}")
    page.locator("#latched").wait_for(state="visible")
    clear_stop(page)
    with open_clinic(served.folder) as clinic:
        clinic.catalogue.set(Setting(key=IDLE_KEY, content=json.dumps(IDLE_S), by="console"))
    seconds = page.locator("body").get_attribute
    until(page, lambda: (page.reload(), seconds("data-idle-s") == str(IDLE_S))[1], "it was never set")
    page.locator("#panel-play input[name=minutes]").fill("7")
    for _ in range(3):  # a machine too busy to keep time stops or holds the movement, as it must
        play(page, ids["patient"])
        expect(page.locator("#cover")).to_be_visible()
        if state(page) == "playing" and desk(page).get_attribute("data-held") == "false":
            break
        unlock(page)
    else:
        pytest.fail("it never moved on below the cover")
    look("63-covered")
    page.locator("#stop-button").click()
    expect(desk(page)).to_have_attribute("data-state", "stopped")
    expect(page.locator(".cover-stopped")).to_be_visible()
    expect(page.locator("#cover")).to_be_visible()
    unlock(page)
    expect(page.locator("#latched")).to_be_visible()
    expect(page.locator("#panel-play input[name=minutes]")).to_have_value("7")


def unlock(page: Page) -> None:
    page.locator("#cover").get_by_label("Password").fill(PASSWORD)
    button(page, "Go on").click()
    expect(page.locator("#cover")).to_be_hidden()


def test_no_script_failed_and_no_dialog_was_opened(page):
    assert [text for text in page.problems if EXPECTED not in text] == []
    assert page.dialogs == []
