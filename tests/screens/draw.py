"""``make screens``: serves the example clinic and takes a picture of every page of it.

Names, numbers and movements are the same in every run; ids and dates are those of the day it is made on.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from rehab_app.bootstrap import open_clinic
from tests.browser.clinic_server import serving
from tests.screens import acts
from tests.screens.example_clinic import ADMINISTRATOR, PASSWORD, PATIENT, Seeded, seed
from tests.screens.shots import (
    DESKTOP,
    EVERY,
    FIRST_RUN,
    FOR_THE_PATIENT,
    SHOTS,
    SIGNED_OUT,
    TABLET,
    TOO_LATE,
    Shot,
)

FOLDER = Path(__file__).parents[2] / "docs" / "screens"
MOST_BYTES = 150_000
_TRIES = ((256, 1.0), (128, 1.0), (128, 0.75), (96, 0.6), (64, 0.5))


def pictures(shot: Shot) -> tuple[str, ...]:
    """Names of the files of a picture: at the desk, then on the tablet where it is asked for."""
    return (f"{shot.name}.png", *([f"{shot.name}-tablet.png"] if shot.tablet else []))


def squeezed(png: bytes) -> bytes:
    """The picture as a PNG within the bound: of fewer colours, or where it holds a photograph, smaller."""
    whole: Any = Image.open(io.BytesIO(png)).convert("RGB")
    kept = b""
    for colours, share in _TRIES:
        picture = whole if share == 1.0 else whole.resize([round(share * side) for side in whole.size])
        file = io.BytesIO()
        picture.quantize(colours, dither=Image.Dither.NONE).save(file, "PNG", optimize=True)
        kept = file.getvalue()
        if len(kept) < MOST_BYTES:
            break
    return kept


def keep(page: Any, name: str) -> None:
    """One picture of a page as it is now."""
    (FOLDER / name).write_bytes(squeezed(page.screenshot()))


def take(page: Any, address: str, seeded: Seeded, shot: Shot) -> None:
    """Open the page, bring it into its state, keep its pictures."""
    page.set_viewport_size({"width": DESKTOP[0], "height": DESKTOP[1]})
    if not shot.state or shot.state in acts.FRESH:
        page.goto(address + seeded.fill(shot.path), wait_until="load")
    acts.ready(page, shot.state)
    names = pictures(shot)
    if shot.state == "playing":
        acts.fresh(page)
    keep(page, names[0])
    if shot.tablet:
        page.set_viewport_size({"width": TABLET[0], "height": TABLET[1]})
        page.wait_for_timeout(800)
        if shot.state == "playing":
            acts.fresh(page)
        keep(page, names[1])
    sys.stderr.write(f"{shot.name}\n")


def series(browser: Any, address: str, seeded: Seeded, shots: Sequence[Shot], name: str = "") -> None:
    """Pictures by one person, who signs in first where there is a name."""
    page = browser.new_context(viewport={"width": DESKTOP[0], "height": DESKTOP[1]}, locale="en").new_page()
    page.set_default_timeout(180_000)
    if name:
        acts.sign_in(page, address, name, PASSWORD)
    for shot in shots:
        take(page, address, seeded, shot)
    page.context.close()


def too_late(browser: Any, address: str, folder: Path, seeded: Seeded) -> None:
    """A note that was sent after the sign-in had ended."""
    page = browser.new_context(viewport={"width": DESKTOP[0], "height": DESKTOP[1]}, locale="en").new_page()
    acts.sign_in(page, address, ADMINISTRATOR, PASSWORD)
    page.goto(address + seeded.fill("/patients/{patient}/journal"))
    with open_clinic(folder) as clinic:
        clinic.accounts.sign_ins.end_all(ADMINISTRATOR)
    page.wait_for_timeout(2500)  # a sign-in that was seen just now is believed for two seconds
    page.fill("textarea[name=text]", "Opens the hand to 60 mm today, with the wrist straight.")
    page.click("form[action$='/journal/note'] button[type=submit]")
    page.wait_for_url("**/sign-in*")
    acts.typed(page, ADMINISTRATOR, PASSWORD)
    page.wait_for_url("**/kept*")
    keep(page, pictures(TOO_LATE[0])[0])
    page.context.close()


def listed() -> str:
    """The list of all pictures."""
    rows = [
        f"| `{shot.path.partition('?')[0]}` | {shot.words} | "
        f"{' '.join(f'[{name}]({name})' for name in pictures(shot))} |"
        for shot in EVERY
    ]
    return "\n".join([*_HEAD, *rows, ""])


_HEAD = (
    "# Every page in a picture",
    "",
    "Made by `make screens`: an example clinic with simulated devices and people who do not exist, looked at",
    f"in Chromium at {DESKTOP[0]} x {DESKTOP[1]}, and at {TABLET[0]} x {TABLET[1]} as on a tablet. Names,",
    "values and movements come from a fixed seed; dates and ids are those of the day on which the pictures",
    "were made. A test refuses a page that has neither a picture here nor a reason why not.",
    "",
    "| Page | What it shows | Pictures |",
    "|---|---|---|",
)


def main(wanted: Sequence[str]) -> None:
    """Draw all pictures, or only those whose names are given."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    chosen = [shot for shot in EVERY if not wanted or shot.name in wanted]
    with tempfile.TemporaryDirectory() as made, acts.chromium(Path(made)) as browser:
        empty, folder = Path(made) / "empty", Path(made) / "clinic"
        if set(FIRST_RUN) & set(chosen):
            open_clinic(empty).close()
            with serving(empty) as server:
                series(browser, server.address, Seeded("", "", "", "", ""), FIRST_RUN)
        seeded = seed(folder)
        with serving(folder) as server:
            for shots, name in ((SIGNED_OUT, ""), (FOR_THE_PATIENT, PATIENT)):
                series(browser, server.address, seeded, [one for one in shots if one in chosen], name)
            if TOO_LATE[0] in chosen:
                too_late(browser, server.address, folder, seeded)
            series(browser, server.address, seeded, [one for one in SHOTS if one in chosen], ADMINISTRATOR)
    known = {name for shot in EVERY for name in pictures(shot)}
    for left in {path for path in FOLDER.glob("*.png") if path.name not in known}:
        left.unlink()
    (FOLDER / "README.md").write_text(listed(), encoding="utf-8")


if __name__ == "__main__":
    if shutil.which("chromium") is None:
        sys.exit(
            "Chromium is absent: install it (Debian: apt-get install chromium) and run make screens again."
        )
    main(sys.argv[1:])
