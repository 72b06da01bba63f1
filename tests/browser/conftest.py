"""A clinic served by the real command, and a real Chromium that looks at it."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic

from .clinic_server import serving

NAME, PASSWORD = "anna", "a hand that opens"
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--no-first-run",
)


@dataclass(frozen=True)
class Served:
    """A running server.

    ``address`` ends without a slash; ``folder`` is its clinic.
    """

    address: str
    folder: Path


@pytest.fixture(scope="session")
def chromium():
    """Path of Chromium; without it a skip, and in CI a failure."""
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        words = (
            "Chromium is absent: install it (Debian: apt-get install chromium) to drive the clinic with it"
        )
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(words)
    return path


@pytest.fixture(scope="module")
def served(tmp_path_factory, chromium):
    """The clinic at a free port: one therapist, one patient, nothing recorded yet."""
    folder = tmp_path_factory.mktemp("clinic")
    with open_clinic(folder) as clinic:
        clinic.accounts.add_user(NAME, "therapist", PASSWORD, CONSOLE)
        clinic.patients.add(
            CONSOLE, given_name="Clara", family_name="Weber", birth_date="1957-03-14", side="right"
        )
    with serving(folder) as server:
        yield Served(server.address, folder)


@pytest.fixture(scope="session")
def patient_chromium(chromium, tmp_path_factory):
    """Chromium at low priority: without a graphics card its drawing would starve the robot.

    Chromium raises its drawing process to nice -8 wherever it may, as root may; so it loses that right first.
    """
    path = tmp_path_factory.mktemp("chromium") / "chromium"
    drop = "setpriv --bounding-set=-sys_nice" if os.geteuid() == 0 and shutil.which("setpriv") else ""
    path.write_text(f'#!/bin/sh\nexec nice -n 10 {drop} {chromium} "$@"\n')
    path.chmod(0o755)
    return path


@pytest.fixture(scope="module")
def chrome(patient_chromium):
    """The browser."""
    from playwright.sync_api import expect, sync_playwright

    expect.set_options(timeout=60_000)

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=patient_chromium, args=list(_FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def visitor(chrome):
    """Opens a page for one more person: cookies of its own, 1440 x 900 unless told.

    Scripts that fail are collected in ``page.problems``, dialogs in ``page.dialogs``.
    """

    def opened(width=1440, height=900, **more):
        page = chrome.new_context(viewport={"width": width, "height": height}, **more).new_page()
        page.set_default_timeout(60_000)
        page.problems, page.dialogs = [], []
        page.on("pageerror", lambda error: page.problems.append(str(error)))
        page.on("dialog", lambda dialog: (page.dialogs.append(dialog.message), dialog.dismiss()))
        return page

    return opened


@pytest.fixture(scope="module")
def page(visitor):
    """The page of one person."""
    return visitor()


@pytest.fixture
def look(page, tmp_path):
    """Takes a screenshot into REHAB_SCREENSHOTS, at desktop and tablet size."""
    folder = Path(os.environ.get("REHAB_SCREENSHOTS") or tmp_path)
    folder.mkdir(parents=True, exist_ok=True)

    def taken(name, tablet=False):
        page.screenshot(path=folder / f"{name}.png")
        if tablet:
            page.set_viewport_size({"width": 1024, "height": 768})
            page.screenshot(path=folder / f"{name}-tablet.png")
            page.set_viewport_size({"width": 1440, "height": 900})

    return taken
