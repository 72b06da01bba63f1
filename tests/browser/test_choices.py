"""A clinic of many patients: one is found by typing, and confirmed anew each time another one is chosen."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from tests.bench.large_clinic import Size, fill

from .clinic_server import serving
from .conftest import NAME, PASSWORD
from .test_axe import AXE, SERIOUS
from .test_clinic import EXPECTED

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]


@pytest.fixture(scope="module")
def live(tmp_path_factory, page):
    """The live page of a clinic with sixty patients."""
    folder = tmp_path_factory.mktemp("many")
    url = f"sqlite:///{folder / 'clinic.sqlite3'}"
    with open_clinic(folder, settings=Settings(catalogue_url=url)) as clinic:
        clinic.accounts.add_user(NAME, "therapist", PASSWORD, CONSOLE)
        fill(clinic, url, Size(patients=60, sessions=300, takes=120))
        clinic.patients.add(
            CONSOLE, given_name="Ida", family_name="Berg", birth_date="1957-03-14", side="left"
        )
        clinic.patients.add(
            CONSOLE, given_name="Ida", family_name="Berg", birth_date="1961-07-02", side="right"
        )
    with serving(folder) as server:
        page.goto(server.address + "/sign-in")
        page.get_by_label("Name").fill(NAME)
        page.get_by_label("Password").fill(PASSWORD)
        page.get_by_role("button", name="Sign in").click()
        page.wait_for_url("**/live")
        yield page
    assert [one for one in page.problems if EXPECTED not in one] == []


def found(live):
    return live.locator("#sought-patient [role=option]")


def test_one_of_two_namesakes_is_found_and_confirmed(live):
    chosen, present = live.locator("select[name=patient]"), live.get_by_label("At the robot")
    live.locator("#seek-patient").fill("berg ida")
    expect(found(live)).to_have_count(2)
    expect(found(live).first).to_contain_text("born 14 March 1957, left")
    live.keyboard.press("Enter")  # nothing is marked: it chooses nobody, and starts nothing
    expect(chosen).to_have_value("")
    live.keyboard.press("ArrowDown")
    live.keyboard.press("ArrowDown")
    expect(found(live).nth(1)).to_have_attribute("aria-selected", "true")
    live.keyboard.press("Enter")
    expect(live.locator("#confirm")).to_contain_text("Ida Berg, born 2 July 1961, RIGHT hand")
    expect(live.locator("#patient")).to_contain_text("born 2 July 1961")
    expect(present).not_to_be_checked()
    expect(found(live)).to_have_count(2)  # kept for the next opening, but not shown
    expect(live.locator("#sought-patient")).to_be_hidden()
    present.check()
    live.locator("#seek-patient").fill("14.3.1957")
    found(live).first.click()
    expect(live.locator("#confirm")).to_contain_text("Ida Berg, born 14 March 1957, LEFT hand")
    expect(present).not_to_be_checked()
    expect(present).to_have_value(chosen.input_value())
    expect(live.locator("#main")).to_have_attribute("data-state", "idle")


def test_a_search_leaves_who_is_chosen(live):
    chosen = live.locator("select[name=patient]")
    before = chosen.input_value()
    live.get_by_label("At the robot").check()
    live.locator("#seek-patient").fill("nobody at all")
    expect(live.locator(".chooser:has(#seek-patient) .sought")).to_contain_text("Nothing is found.")
    live.locator("#seek-patient").fill("")
    live.get_by_label("Repetitions").click()
    expect(chosen).to_have_value(before)
    expect(live.get_by_label("At the robot")).to_be_checked()


def test_a_take_is_found_and_chosen(live):
    live.locator("#seek-take").fill("pinch left")
    live.locator("#sought-take [role=option]").nth(3).click()
    expect(live.locator("select[name=take] option:checked")).to_contain_text("Tip pinch, left")


def test_what_was_found_is_accessible_on_a_tablet(live):
    if not AXE.is_file():
        pytest.skip("axe-core is absent: run npm install in tests/foreign")
    live.set_viewport_size({"width": 1024, "height": 768})
    live.locator("#seek-patient").fill("rossi")
    expect(found(live).first).to_be_visible()
    live.keyboard.press("ArrowDown")
    box = found(live).first.bounding_box()
    assert box is not None
    assert box["height"] >= 44
    live.evaluate(f"() => {{ {AXE.read_text(encoding='utf-8')} }}")
    told = live.evaluate("async () => (await axe.run('#desk')).violations")
    assert [one["id"] for one in told if one["impact"] in SERIOUS] == []
