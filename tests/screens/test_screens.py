"""No page is forgotten: each has a picture in the documentation, or a reason why it has none."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.rehab_app.web.test_matrix import GATEWAY, OPEN, VERBS
from tests.screens.draw import FOLDER, MOST_BYTES, pictures
from tests.screens.shots import EVERY, NO_PICTURE

PAGES = {line for line in {*VERBS, *OPEN, *GATEWAY} if line.startswith("GET ")}


def test_every_page_has_a_picture_or_a_reason():
    shown = {shot.route for shot in EVERY if shot.route}
    assert shown | set(NO_PICTURE) == PAGES
    assert not shown & set(NO_PICTURE)


def test_every_name_is_used_once():
    assert [name for name, times in Counter(shot.name for shot in EVERY).items() if times > 1] == []


@pytest.mark.parametrize("name", [name for shot in EVERY for name in pictures(shot)])
def test_a_picture_is_there_small_and_named_in_its_list(name: str):
    path = FOLDER / name
    assert path.read_bytes().startswith(b"\x89PNG"), "make screens"
    assert path.stat().st_size < MOST_BYTES
    assert f"({name})" in (FOLDER / "README.md").read_text(encoding="utf-8")


def test_no_picture_is_left_of_a_page_that_is_gone():
    known = {name for shot in EVERY for name in pictures(shot)}
    assert {path.name for path in FOLDER.glob("*.png")} == known
