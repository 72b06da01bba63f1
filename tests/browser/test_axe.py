"""Accessibility: axe-core finds nothing serious on any page of the shell, in either language."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.order import Order
from rehab_app.services.retouching import Wish
from rehab_app.web.language import COOKIE, LANGUAGES

from .clinic_server import serving

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[1] / "foreign" / "node_modules" / "axe-core" / "axe.min.js"
ADMINISTRATOR, SCREEN, PASSWORD = "ada", "screen", "a hand that opens"
PAGES = (
    "/live",
    "/help",
    "/patients",
    "/patients/new",
    "/patients/{patient}",
    "/patients/{patient}/edit",
    "/patients/{patient}/diagnosis",
    "/patients/{patient}/limits",
    "/patients/{patient}/plan",
    "/patients/{patient}/plan?add=open_close",
    "/patients/{patient}/progress",
    "/patients/{patient}/assessments",
    "/patients/{patient}/outcomes",
    "/patients/{patient}/journal",
    "/patients/{patient}/sessions",
    "/patients/{patient}/data",
    "/patients/{patient}/compare",
    "/patients/{patient}/compare?first={earlier}&second={session}",
    "/patients/{patient}/next",
    "/exercises",
    "/exercises/open_close",
    "/takes",
    "/takes/{take}",
    "/takes/{take}/report",
    "/takes/{take}/names",
    "/takes/{retouched}/compare",
    "/sessions",
    "/sessions/{session}",
    "/sessions/{session}/report",
    "/mine",
    "/account",
    "/clinic",
    "/clinic/users",
    "/clinic/audit",
    "/clinic/devices",
    "/clinic/settings",
    "/clinic/stations",
    "/clinic/calibration",
    "/clinic/backup",
    "/there-is-no-such-page",
)
MEASURED = ("/report", "/progress", "&second={session}")
SERIOUS = {"serious", "critical"}


@pytest.fixture(scope="module")
def axe():
    """The text of axe-core; without it a skip, and in CI a failure."""
    if not AXE.is_file():
        fail = pytest.fail if os.environ.get("CI") == "true" else pytest.skip
        fail("axe-core is absent: run npm install in tests/foreign")
    return AXE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def ids(served):
    """A patient, takes and played sessions of the clinic, and an administrator, who may open every page."""
    with open_clinic(served.folder) as clinic:
        clinic.accounts.add_user(ADMINISTRATOR, "administrator", PASSWORD, CONSOLE)
        take = clinic.takes.record_virtual("open_close", "right", 1.5, 3, CONSOLE).take
        clinic.takes.approve(take, CONSOLE)
        patient = clinic.patients.list()[0].id
        order = Order(speed=1.0, repetitions=1)
        plan = clinic.therapy.plan(take, order, actor=CONSOLE, patient_id=patient)
        played = [clinic.therapy.rehearse_and_play(plan, actor=CONSOLE, present=patient) for _ in range(2)]
        retouched = clinic.retouching.retouch(take, Wish(trim_s=(0.2, 1.4)), "to look at", actor=CONSOLE).id
        clinic.accounts.add_user(SCREEN, "patient", PASSWORD, CONSOLE, patient)
        earlier, session = (one.session for one in played)
        return {
            "patient": patient,
            "take": take,
            "retouched": retouched,
            "earlier": earlier,
            "session": session,
        }


def violations(page, axe):
    """What axe-core calls serious or critical, one line each; pictures in frames are other pages."""
    # evaluated by the driver, which the page's content policy does not bind
    page.evaluate(axe + "; 0")
    found = page.evaluate(
        "async () => (await axe.run(document, { iframes: false, resultTypes: ['violations'] })).violations"
    )
    return [
        f"{one['id']}: {node['target']} {node['html'][:120]}"
        for one in found
        if one["impact"] in SERIOUS
        for node in one["nodes"]
    ]


def sign_in(page, served, name=ADMINISTRATOR):
    page.goto(served.address + "/sign-in")
    page.fill("input[name=name]", name)
    page.fill("input[name=password]", PASSWORD)
    page.click("main button[type=submit]")
    page.wait_for_url(re.compile(r"/(live|patients|clinic|mine|$)"))


def test_no_page_has_a_serious_violation(page, served, ids, axe):
    problems = {}
    for language in LANGUAGES:
        page.context.add_cookies([{"name": COOKIE, "value": language, "url": served.address}])
        if language == "en":
            page.goto(served.address + "/sign-in")
            problems["/sign-in"] = violations(page, axe)
            sign_in(page, served)
        for path in PAGES:
            # a report is measured while its page waits: leave it only when it is there
            until = "load" if path.endswith(MEASURED) else "domcontentloaded"
            answer = page.goto(served.address + path.format(**ids), wait_until=until, timeout=180_000)
            assert answer.ok or path == PAGES[-1], path
            assert page.get_attribute("html", "lang") == language
            problems[f"{language} {path}"] = violations(page, axe)
    assert not {path: found for path, found in problems.items() if found}


def test_the_screen_of_a_patient_has_no_serious_violation(visitor, served, ids, axe):
    """As the patient whose it is sees it, beside the robot, also once the server is gone."""
    page = visitor()
    sign_in(page, served, SCREEN)
    assert page.url.endswith("/mine")
    assert violations(page, axe) == []
    page.evaluate("document.getElementById('stop').classList.add('failed')")
    assert violations(page, axe) == []


def test_the_live_page_has_no_serious_violation_in_any_tab(visitor, served, ids, axe):
    page = visitor()
    sign_in(page, served)
    page.goto(served.address + "/live")
    for tab in ("Session", "Therapy", "Record a take"):
        page.get_by_role("tab", name=tab).click()
        assert violations(page, axe) == [], tab


def test_a_form_that_came_too_late_has_no_serious_violation(visitor, served, ids, axe):
    """What was typed while the sign-in had ended, shown again."""
    page = visitor()
    page.goto(served.address + "/sign-in")
    sign_in(page, served)
    page.goto(served.address + f"/patients/{ids['patient']}/journal")
    with open_clinic(served.folder) as clinic:
        clinic.accounts.sign_ins.end_all(ADMINISTRATOR)
    page.wait_for_timeout(2500)  # a sign-in that was seen just now is believed for two seconds
    page.fill("textarea[name=text]", "late, but kept")
    page.click("form[action$='/journal/note'] button[type=submit]")
    page.wait_for_url(re.compile("/sign-in"))
    page.fill("input[name=name]", ADMINISTRATOR)
    page.fill("input[name=password]", PASSWORD)
    page.click("main button[type=submit]")
    page.wait_for_url(re.compile("/kept"))
    assert violations(page, axe) == []
    expect(page.get_by_label("What should be known")).to_have_value("late, but kept")
    assert page.locator("main label:visible").count() == 1, "what a page fills in is sent, but not shown"


def test_the_first_page_of_an_empty_clinic_has_no_serious_violation(visitor, tmp_path, axe):
    """Where the first account is made."""
    with open_clinic(tmp_path):
        pass
    with serving(tmp_path) as server:
        page = visitor()
        for language in LANGUAGES:
            page.context.add_cookies([{"name": COOKIE, "value": language, "url": server.address}])
            page.goto(server.address + "/set-up")
            assert page.get_attribute("html", "lang") == language
            assert violations(page, axe) == []


def test_every_page_of_the_shell_is_looked_at(served):
    """A page that is added later must be added above."""
    from rehab_app.web import create_app

    apart = re.compile(
        r"^/($|sign-in|set-up|stop/|here|healthz|metrics$|kept|unlock|prescribe|exercise-pictures|live/.)"
        r"|/view/|/state$|/first.jpg$|\.(svg|csv|html|json|\{)|\.\{?format|/board|/file/"
    )
    with open_clinic(served.folder) as clinic:
        paths = {
            route.path
            for route in create_app(clinic, open_viewports=lambda _: None).routes
            if "GET" in (getattr(route, "methods", None) or ())
        }
    ids = {"patient": "{patient}"} | dict.fromkeys(("take", "retouched", "session", "earlier"), "{recording}")
    shapes = {path.partition("?")[0].format(**ids) for path in PAGES}
    shapes = {re.sub("^/exercises/.*", "/exercises/{name:path}", shape) for shape in shapes}
    assert not {path for path in paths if not apart.search(path)} - shapes
