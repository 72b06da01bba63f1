"""A target grip in a real browser: chosen on the live page, played towards, looked at again in the review."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from playwright.sync_api import FrameLocator, Page, expect

from .conftest import NAME, PASSWORD
from .test_clinic import EXPECTED, button, clear_stop, desk, moves_on, state, until

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

NEAR_MM = 20
"""The device ends the thumb's base 5 degrees before its place: its tip stays some 14 mm away."""
CYLINDER = "Cylinder of 60 mm, transverse grip"
SEALED = re.compile("^Session [0-9a-f]{8}")
"""What the live page says once a stopped session has braked and is sealed."""


def picture(page: Page) -> FrameLocator:
    return page.frame_locator("iframe[data-viewport]")


def console(*words):
    """Run ``rehab-app`` beside the server, as somebody at the console would."""
    subprocess.run(
        [sys.executable, "-m", "rehab_app", *(str(word) for word in words)], check=True, capture_output=True
    )


def test_a_target_is_chosen_and_appears(page, served, look):
    page.goto(served.address)
    page.get_by_label("Name").fill(NAME)
    page.get_by_label("Password").fill(PASSWORD)
    button(page, "^Sign in$").click()
    page.wait_for_url("**/live")
    page.locator("#aim summary").click()
    page.get_by_label("Object").select_option("cylinder")
    expect(picture(page).get_by_text(CYLINDER)).to_be_visible()
    expect(picture(page).get_by_text("Target, outlined")).to_be_visible()
    expect(picture(page).get_by_text("No hand is measured now.")).to_be_visible()
    expect(page.locator("[data-show=target-words]")).to_have_text("Cylinder of 60 mm, transverse grip")
    page.wait_for_timeout(1000)
    look("20-target", tablet=True)


def test_a_box_asks_for_two_sizes_and_what_no_hand_holds_is_a_sentence(page, look):
    expect(page.get_by_label("Width, mm")).to_be_hidden()
    page.get_by_label("Object").select_option("box")
    expect(page.get_by_label("Thickness, mm")).to_be_visible()
    expect(page.get_by_label("Width, mm")).to_be_visible()
    page.get_by_label("Object").select_option("cylinder")
    page.get_by_label("Diameter, mm").fill("300")
    page.get_by_label("Diameter, mm").press("Tab")
    sentence = re.compile(r"300 mm thick, but must be \d+ to \d+ mm for this hand")
    expect(picture(page).get_by_text(sentence)).to_be_visible()
    look("21-target-refused")
    page.get_by_label("Diameter, mm").fill("60")
    page.get_by_label("Diameter, mm").press("Tab")
    expect(picture(page).get_by_text(CYLINDER)).to_be_visible()


def test_a_grasp_becomes_a_take_that_is_played_to_its_target(page, served, look, tmp_path):
    take = tmp_path / "grasp.mcap"
    console(*("grasp", "--object", "cylinder:radius=0.03", "--hand", "human", "--take", take))
    console("approve", take, "--by", NAME, "--data", served.folder)
    page.reload()
    expect(page.locator("select[name=take]")).to_contain_text("Cylinder of 60 mm, transverse grip")
    expect(page.get_by_label("Object")).to_have_value("cylinder")
    play(page)
    figure = page.locator("[data-show=target]")
    expect(figure).to_have_text(re.compile(r"^\d+ mm \((thumb|index|middle|ring|little)\)$"))
    expect(picture(page).get_by_text(re.compile(r"^Aperture \d+ degrees of \d+$"))).to_be_visible()
    look("22-target-playing", tablet=True)
    nearest = nearest_mm(page)
    for _ in range(2):  # a busy machine may have ended the session on the way
        if nearest < NEAR_MM:
            break
        play(page)
        nearest = min(nearest, nearest_mm(page))
    assert nearest < NEAR_MM, f"the grasp was played, and its own target stayed {nearest} mm away"
    look("23-target-near")
    page.keyboard.press("Escape")
    expect(desk(page)).to_have_attribute("data-state", "stopped")
    expect(page.get_by_text(SEALED)).to_be_visible()


def play(page: Page) -> None:
    """Play the newest take as a demonstration; where a busy machine stops the session, start it again."""
    for _ in range(3):
        if state(page) == "stopped":
            expect(page.get_by_text(SEALED)).to_be_visible()
            clear_stop(page)
        page.locator("select[name=patient]").select_option(index=0)
        button(page, "Rehearse and play").click()
        expect(desk(page)).to_have_attribute("data-state", "playing")
        until(page, lambda: moves_on(page) or state(page) != "playing", "the hand never moved")
        if state(page) == "playing":
            return
    pytest.fail("three sessions ended before they moved the hand")


def nearest_mm(page: Page) -> int:
    """The least distance to go that the strip shows within fifteen seconds, or until the session ends."""
    shown = [1000]
    for _ in range(150):
        text = page.locator("[data-show=target]").text_content() or ""
        shown += [int(number) for number in re.findall(r"^\d+", text)]
        if shown[-1] < NEAR_MM or state(page) != "playing":
            break
        moves_on(page)  # what a stale picture held goes on
        page.wait_for_timeout(100)
    return min(shown)


def test_the_review_begins_with_the_target_that_was_played_and_shows_another(page, served, look):
    page.goto(served.address + "/sessions")
    page.get_by_role("link", name="Review").first.click()
    shown = picture(page)
    expect(shown.get_by_text(CYLINDER)).to_be_visible()
    expect(shown.get_by_text("Target, outlined")).to_be_visible()
    expect(shown.get_by_text(re.compile("mm to go|every fingertip within"))).to_be_visible()
    look("24-target-review", tablet=True)
    shown.get_by_label("Object").click()
    shown.get_by_role("option", name="Ball").click()
    expect(shown.get_by_text("Ball of 60 mm")).to_be_visible()
    look("25-target-review-another")


def test_no_script_failed(page):
    assert [text for text in page.problems if EXPECTED not in text] == []
