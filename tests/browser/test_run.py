"""Runs in a real browser: active-assisted therapy that goes back and is stopped; today's range measured."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, TimeoutError, expect

from .conftest import NAME, PASSWORD
from .test_clinic import EXPECTED, button, clear_stop, desk, moves_on, state, until

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

RANGE_S = 300.0


def command(*words):
    """Run ``rehab-app`` beside the server, as somebody at the console would; returns what it said."""
    done = subprocess.run(
        [sys.executable, "-m", "rehab_app", *(str(word) for word in words)],
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout


def phase(page: Page) -> str:
    return page.locator("[data-show=phase]").inner_text()


def said(page: Page) -> str:
    return page.locator("#said").inner_text()


def start(page: Page, words: str) -> None:
    """Choose the patient, confirm who it is, and press a button of the form."""
    if state(page) == "stopped":
        clear_stop(page)
    page.locator("select[name=patient]").select_option(index=1)
    page.get_by_label("At the robot").check()
    button(page, words).click()
    expect(desk(page)).to_have_attribute("data-state", "playing")


def test_the_form_says_whom_it_is_for_and_where_limits_come_from(page, served, look):
    folder = served.folder
    take = folder / "take.mcap"
    command("record", "--seconds", 4, "--out", take, "--data", folder)
    command("approve", take, "--by", NAME, "--data", folder)
    page.goto(served.address)
    page.get_by_label("Name").fill(NAME)
    page.get_by_label("Password").fill(PASSWORD)
    button(page, "^Sign in$").click()
    page.wait_for_url("**/live")
    expect(page.locator("[data-show=limits]")).to_contain_text("average hand")
    expect(button(page, "Measure today")).to_be_disabled()
    page.locator("select[name=patient]").select_option(index=1)
    expect(page.locator("#confirm")).to_contain_text("Clara Weber, born 14 March 1957, RIGHT hand")
    expect(page.locator("[data-show=limits]")).to_contain_text("not measured today")
    look("30-form", tablet=True)
    page.locator("#panel-play").get_by_text("Details", exact=True).click()
    page.get_by_label("Mode").select_option("resistive")
    expect(page.get_by_label("Resistance, %")).to_be_visible()
    look("31-form-details", tablet=True)
    page.get_by_label("Mode").select_option("assistive")
    expect(page.get_by_label("Resistance, %")).to_be_hidden()
    button(page, "Rehearse and play").click()  # nobody said who sits there: the browser asks, nothing starts
    assert state(page) == "idle"


STEPS = (
    ("Reverse", "Going back", "Going back", "32-going-back"),
    ("Resume forwards", "Playing", "", ""),
    ("Pause", "Held", "Paused", "33-held"),
    ("Resume", "Playing", "", ""),
)
"""A button, the word of the state that follows, what is said, and the picture of it."""


def press(page: Page, look: Callable[..., None], words: str, shown: str, told: str, picture: str) -> bool:
    """Press a button and wait for the state that it leads to; whether the session still goes on."""
    try:
        button(page, words).click(timeout=10_000)
    except TimeoutError:
        assert state(page) != "playing", f"{words} cannot be pressed"
        return False
    word = page.locator("#state-word")
    until(page, lambda: shown in word.inner_text() or state(page) != "playing", f"{words}: never {shown}")
    if picture and state(page) == "playing":
        expect(page.locator("#said")).to_contain_text(told)
        look(picture, tablet=True)
    return state(page) == "playing"


def test_active_assisted_goes_back_is_held_and_stopped(page, look):
    page.get_by_label("Mode").select_option("assistive")
    page.get_by_label("Warm-up, first").fill("2")
    page.get_by_label("Repetitions").fill("6")
    page.get_by_label("Speed, %").first.fill("40")
    for _ in range(3):  # a machine too busy to keep time stops the session, as it must
        start(page, "Rehearse and play")
        until(page, lambda: moves_on(page) or state(page) != "playing", "the hand never moved")
        if state(page) == "playing" and all(press(page, look, *step) for step in STEPS):
            break
    else:
        pytest.fail("three sessions ended before they were held and resumed")
    expect(page.locator("[data-show=run]")).to_have_text("Active-assisted, Exoskeleton (simulation)")
    page.keyboard.press("Escape")
    expect(desk(page)).to_have_attribute("data-state", "stopped")
    look("34-stopped", tablet=True)
    expect(page.get_by_text(re.compile("^Session [0-9a-f]{8}"))).to_be_visible()


def sweep(page: Page, look: Callable[..., None]) -> list[str]:
    """Measure once; returns the phases that were shown. Pictures are dear here, so there are two."""
    start(page, "Measure today")
    expect(page.locator("[data-show=run]")).to_contain_text("Today's range")
    seen: list[str] = []

    def measured() -> bool:
        moves_on(page)
        words = phase(page) if state(page) == "playing" else ""
        if words and words not in seen:
            seen.append(words)
            if words in ("Tabletop: alone", "Full fist: led on"):
                look("35-range-" + words.partition(":")[0].replace(" ", "-").lower())
        return state(page) != "playing"

    until(page, measured, "the sweep never ended", RANGE_S)
    return seen


def test_todays_range_is_measured_and_the_form_says_so(page, look):
    for _ in range(3):
        seen = sweep(page, look)
        if state(page) != "stopped":  # so busy a machine that the supervisor stopped it, as it must
            break
        until(page, lambda: "safety supervisor:" in said(page), "the cause was never told")
        clear_stop(page)
    assert state(page) == "done", said(page)
    postures = [word for word in seen if ": alone" in word]
    assert postures == ["Open hand: alone", "Tabletop: alone", "Hook fist: alone", "Full fist: alone"]
    expect(page.locator("#said")).to_contain_text("Today's range is measured")
    expect(page.locator("[data-show=limits]")).to_have_text(re.compile(r"Measured today \d\d:\d\d, wrist 0°"))
    look("36-measured", tablet=True)
    page.locator("#panel-play input[name=wrist]").fill("40")
    page.locator("#panel-play input[name=wrist]").blur()
    expect(page.locator("[data-show=limits]")).to_contain_text("Wrist angle is 40 degrees")
    look("37-another-wrist")


def test_the_sweep_can_be_looked_at_again(page, look):
    page.locator("[data-link=session]").click()
    picture = page.frame_locator("iframe[data-viewport]")
    expect(picture.get_by_text("Guided assessment: nobody is followed.").first).to_be_visible()
    look("38-range-review")


def test_no_script_failed(page):
    assert [text for text in page.problems if EXPECTED not in text] == []
