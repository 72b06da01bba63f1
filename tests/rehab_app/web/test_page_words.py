"""Names of joints and of kept fields, as people read them."""

from __future__ import annotations

import pytest

from rehab_app.web import words
from rehab_app.web.language import speak
from rehab_app.web.pages import kept
from rehab_app.web.render import joint
from robot_iface.types.hand import JOINTS
from sessions.reports import wording


@pytest.fixture(autouse=True)
def english():
    yield
    speak("en")


@pytest.mark.parametrize(
    ("name", "told", "detto"),
    [
        ("index_mcp_flexion", "Index MCP flexion", "Indice MCP flessione"),
        ("thumb_cmc_abduction", "Thumb CMC abduction", "Pollice CMC abduzione"),
        ("little_dip", "Little DIP", "Mignolo DIP"),
        ("joint1", "Joint1", "Joint1"),
    ],
)
def test_a_joint_in_words(name, told, detto):
    assert joint(name) == told
    speak("it")
    assert joint(name) == detto


def test_no_joint_is_shown_as_an_identifier():
    assert not [name for name in JOINTS if "_" in joint(name)]


@pytest.mark.parametrize("name", ["back", "corrects", "was", "was_place", "version", "key"])
def test_what_a_page_fills_in_is_sent_again_unseen(name):
    assert kept._shown(name, "7").unseen


def test_what_a_person_typed_is_shown_under_its_label():
    field = kept._shown("happened", "The strap slipped.\nTwice.")
    assert (field.words, field.unseen, field.long) == ("What happened", False, True)
    assert kept._shown("own_thing", "x").words == "Own thing"
    assert kept._shown("remark", " ").unseen


def test_reports_call_exercises_as_the_pages_do() -> None:
    assert wording.EXERCISES == words.EXERCISES
