"""What is done to a page before its picture is taken."""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

FRESH = ("chosen", "session", "record", "playing", "backup")
"""States that begin with the page opened anew; another goes on where the last picture was taken."""
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--no-first-run",
)


@contextmanager
def chromium(folder: Path) -> Generator[Any]:
    """A Chromium at low priority, which never starves the robot.

    Args:
        folder: Where its starter is written.
    """
    from playwright.sync_api import sync_playwright

    # Chromium raises its drawing process wherever it may, as root may: it loses that right first
    drop = "setpriv --bounding-set=-sys_nice" if os.geteuid() == 0 and shutil.which("setpriv") else ""
    starter = folder / "chromium"
    starter.write_text(f'#!/bin/sh\nexec nice -n 10 {drop} {shutil.which("chromium")} "$@"\n')
    starter.chmod(0o755)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=starter, args=list(_FLAGS))
        yield browser
        browser.close()


def typed(page: Any, name: str, password: str) -> None:
    """Type a name and a password and send them."""
    page.fill("input[name=name]", name)
    page.fill("input[name=password]", password)
    page.click("main button[type=submit]")


def sign_in(page: Any, address: str, name: str, password: str) -> None:
    """Sign in, and wait for the page behind it."""
    page.goto(address + "/sign-in")
    typed(page, name, password)
    page.locator("form.who").wait_for()


def ready(page: Any, state: str) -> None:
    """Bring a page into its state and wait until it stands."""
    if state:
        _STATES[state](page)
    if page.locator("#rendering").count():
        page.locator("#rendering").wait_for(state="hidden")
    if page.locator("iframe.picture").count():
        _drawn(page.frame_locator("iframe.picture"))
        page.wait_for_timeout(2500)
    page.wait_for_timeout(400)


def _drawn(picture: Any) -> None:
    """Wait until the 3-D picture stands, and send its word on slow drawing away: a fast machine has none."""
    picture.locator("canvas[data-engine]").wait_for()
    for close in picture.locator(".mantine-Notification-closeButton").all():
        close.click()


def _chosen(page: Any) -> None:
    page.locator("#panel-play select[name=patient]").select_option(index=1)


def _session(page: Any) -> None:
    page.get_by_role("tab", name="Session").click()
    page.wait_for_timeout(500)


def _record(page: Any) -> None:
    page.get_by_role("tab", name="Record a take").click()


def _backup(page: Any) -> None:
    """The folder of a clinic, not that of whoever draws."""
    page.fill("input[name=place]", "/mnt/second-disk/clinic-backups")


def _playing(page: Any) -> None:
    """Therapy with the hand on its way."""
    page.get_by_role("tab", name="Therapy").click()
    _chosen(page)
    page.get_by_label("At the robot").check()
    page.get_by_label("Repetitions").fill("5")
    page.get_by_role("button", name="Rehearse and play").click()
    page.locator("[data-show=phase]").filter(has_text="Target movement").wait_for()
    page.wait_for_timeout(4000)


def fresh(page: Any) -> None:
    """Wait until what is played is shown as it is now.

    A browser that draws without a graphics card falls behind on a busy machine: its picture is called old and
    the hand is held, as it must be; then it is resumed.
    """
    for _ in range(150):
        held = page.get_by_role("button", name="Resume")
        if held.count() and held.is_visible():
            held.click()
        elif not page.locator("#stale").is_visible():
            return
        page.wait_for_timeout(200)


def _stopped(page: Any) -> None:
    page.keyboard.press("Escape")
    page.locator("#latched").wait_for()
    page.wait_for_timeout(3000)  # it brakes and is sealed


_STATES = {
    "chosen": _chosen,
    "session": _session,
    "record": _record,
    "playing": _playing,
    "backup": _backup,
    "stopped": _stopped,
}
