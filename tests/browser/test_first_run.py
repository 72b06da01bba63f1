"""The newcomer's way: an empty clinic, the first account, the first patient, a take, its replay, its report.

Every press of the mouse is counted by the page itself, also one to reach a field that is typed into.
"""

from __future__ import annotations

import re
import sys

import pytest
from playwright.sync_api import Locator, Page, expect

from .clinic_server import serving
from .conftest import PASSWORD
from .test_clinic import EXPECTED, button, clear_stop, desk, moves_on, state, until

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

MOST_CLICKS = 15
COUNT = """addEventListener("pointerdown", () => {
  sessionStorage.setItem("presses", String(Number(sessionStorage.getItem("presses") ?? 0) + 1));
}, true);"""


@pytest.fixture(scope="module")
def served(tmp_path_factory, chromium):
    """A clinic folder in which nobody has an account."""
    with serving(tmp_path_factory.mktemp("new")) as server:
        yield server


@pytest.fixture(scope="module")
def page(visitor):
    """A page that counts the presses in it, in its pictures too."""
    opened = visitor()
    opened.add_init_script(COUNT)
    return opened


def presses(page: Page) -> int:
    return page.evaluate("Number(sessionStorage.getItem('presses') ?? 0)")


def write(field: Locator, text: str) -> None:
    """Type into a field; where it has not the keyboard yet, press on it first, as a newcomer does."""
    if not field.evaluate("field => field === document.activeElement"):
        field.click()
    field.fill(text)


def test_the_first_account_is_made(page, served, look):
    page.goto(served.address)
    expect(page.get_by_role("heading", name="The first account")).to_be_visible()
    look("40-first-account", tablet=True)
    write(page.get_by_label("Name"), "ada")
    write(page.get_by_label("Password, 10"), PASSWORD)
    write(page.get_by_label("Password again"), PASSWORD)
    button(page, "Make the account").click()
    expect(page.get_by_text("No patients yet.")).to_be_visible()
    look("41-no-patients")


def test_the_first_patient_is_added(page, look):
    page.get_by_role("link", name="Add the first patient").click()
    write(page.get_by_label("Given name"), "Clara")
    write(page.get_by_label("Family name"), "Weber")
    write(page.get_by_label("Birth date"), "1957-03-14")
    page.get_by_label("Right").click()
    button(page, "Add the patient").click()
    expect(page.get_by_text("Clara Weber was added.")).to_be_visible()
    look("42-first-patient")


def test_a_take_is_recorded_approved_and_replayed_within_fifteen_clicks(page, look, capsys):
    page.get_by_role("link", name="Start the first session").click()
    page.get_by_role("tab", name="Record a take").click()
    button(page, "Record$").click()
    expect(desk(page)).to_have_attribute("data-state", "recording")
    expect(desk(page)).to_have_attribute("data-state", "done")
    button(page, "Approve").click()
    expect(page.locator("select[name=take]")).not_to_have_value("")
    expect(page.locator("#confirm")).to_contain_text("Clara Weber, born 14 March 1957, RIGHT hand")
    page.get_by_label("At the robot").click()
    button(page, "Rehearse and play").click()
    clicks = presses(page)
    replay(page)
    look("43-first-replay")
    with capsys.disabled():
        sys.stdout.write(f"\nfirst run to the replayed movement: {clicks} clicks (must {MOST_CLICKS})\n")
    assert 8 < clicks <= MOST_CLICKS


def replay(page: Page) -> None:
    """Wait until the hand moves; a machine too busy to keep time stops the session, as it must."""
    for _ in range(3):
        expect(desk(page)).to_have_attribute("data-state", "playing")
        until(page, lambda: moves_on(page) or state(page) != "playing", "the hand never moved")
        if state(page) == "playing":
            return
        clear_stop(page)
        page.get_by_label("At the robot").check()
        button(page, "Rehearse and play").click()
    pytest.fail("three sessions ended before they moved the hand")


def test_the_report_of_that_session_opens_and_is_taken_away_as_a_pdf(page, look, tmp_path):
    page.keyboard.press("Escape")
    expect(page.get_by_text(re.compile("^Session [0-9a-f]{8}"))).to_be_visible()
    page.locator("[data-link=report]").click()
    report = page.frame_locator("#report")
    expect(report.get_by_role("heading", name="Therapy session")).to_be_visible()
    expect(page.get_by_role("heading", name="Clara Weber")).to_be_visible()
    page.locator("details.downloads summary").click()
    look("44-report")
    with page.expect_download() as waiting:
        page.get_by_role("link", name="PDF").click()
    kept = tmp_path / "report.pdf"
    waiting.value.save_as(kept)
    assert re.fullmatch(r"report-[0-9a-f]+\.pdf", waiting.value.suggested_filename)
    content = kept.read_bytes()
    assert content.startswith(b"%PDF-1.")
    assert content.rstrip().endswith(b"%%EOF")
    assert b"Weber" not in content


def test_the_report_opens_by_itself(page, served):
    page.goto(page.locator("#report").evaluate("frame => frame.src"))
    expect(page.get_by_role("heading", name="Therapy session")).to_be_visible()


def test_no_script_failed(page):
    assert [text for text in page.problems if EXPECTED not in text] == []
