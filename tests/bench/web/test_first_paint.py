"""How soon the live page is painted, and how soon its picture lives, in headless Chromium."""

from __future__ import annotations

import os
import shutil
import sys
import time
from pathlib import Path

import pytest

from .clinic_under_load import served

pytestmark = pytest.mark.bench

_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--no-first-run",
)
_PAINT = "() => (performance.getEntriesByName('first-contentful-paint')[0] || {startTime: -1}).startTime"


def gentle(folder: Path) -> Path:
    """Chromium at low priority that may not raise itself."""
    found = shutil.which("chromium") or shutil.which("chromium-browser")
    if found is None:
        pytest.skip("Chromium is absent: install it (Debian: apt-get install chromium)")
    drop = "setpriv --bounding-set=-sys_nice" if os.geteuid() == 0 and shutil.which("setpriv") else ""
    path = folder / "chromium"
    path.write_text(f'#!/bin/sh\nexec nice -n 5 {drop} {found} "$@"\n')
    path.chmod(0o755)
    return path


def listed(times_s: list[float]) -> str:
    return ", ".join(f"{one:.2f}" for one in times_s)


def test_first_paint_and_first_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from playwright.sync_api import sync_playwright

    chromium = gentle(tmp_path)
    paints: list[float] = []
    lives: list[float] = []
    with served(tmp_path / "clinic") as here, sync_playwright() as driver:
        name, _, value = here.sign_in()[0].partition("=")
        browser = driver.chromium.launch(executable_path=chromium, args=list(_FLAGS))
        for _ in range(3):
            room = browser.new_context(viewport={"width": 1440, "height": 900})
            room.add_cookies([{"name": name, "value": value, "url": f"http://{here.host}"}])
            page = room.new_page()
            page.set_default_timeout(60_000)
            begun_s = time.monotonic()
            page.goto(f"http://{here.host}/live", wait_until="commit")
            page.frame_locator("iframe[data-viewport]").locator("[data-frame]").wait_for(state="attached")
            lives.append(time.monotonic() - begun_s)
            paints.append(1e-3 * page.evaluate(_PAINT))
            room.close()
        browser.close()
    with capsys.disabled():
        sys.stdout.write(
            f"\nlive page in Chromium, three times anew: first paint {listed(paints)} s (must 2 s), "
            f"picture alive {listed(lives)} s (must 3.5 s)\n"
        )
    assert min(paints) > 0.0
