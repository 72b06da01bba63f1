"""A clinic served by the real command, and a real Chromium that looks at it."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic

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
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "rehab_app", "serve", "--data", str(folder), "--port", str(port)]
    log = folder / "server.log"
    with (
        log.open("w") as words,
        subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=words) as server,
    ):
        end_s = time.monotonic() + 60.0
        while "is open at" not in log.read_text():
            assert server.poll() is None, log.read_text()
            assert time.monotonic() < end_s, "the server did not open within a minute"
            time.sleep(0.05)
        yield Served(f"http://localhost:{port}", folder)
        server.terminate()
        server.wait(timeout=30)
    assert "Traceback" not in log.read_text(), log.read_text()


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
def page(patient_chromium):
    """A page of 1440 x 900; scripts that fail are collected in ``page.problems``."""
    from playwright.sync_api import expect, sync_playwright

    expect.set_options(timeout=60_000)

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=patient_chromium, args=list(_FLAGS))
        opened = browser.new_page(viewport={"width": 1440, "height": 900})
        opened.set_default_timeout(60_000)
        opened.problems = []
        opened.on("pageerror", lambda error: opened.problems.append(str(error)))
        yield opened
        browser.close()


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
