"""The record form: cameras of this machine, protocols that can be seen, and sentences for everything else."""

from __future__ import annotations

import pytest

RECORD = {"exercise": "open_close", "side": "right", "seconds": "2", "countdown": "0"}


def test_cameras_are_listed_with_what_they_lack(browser):
    rows = browser("therapist").get("/live/cameras").json()
    assert rows[0]["id"] == "virtual"
    assert rows[0]["ready"]
    for row in rows:
        assert set(row) == {"id", "words", "ready", "state", "state_words", "has_depth", "remedy"}
        assert row["ready"] or row["remedy"]


def test_cameras_are_for_those_who_may_record(browser):
    assert browser("auditor").get("/live/cameras").status_code == 403


def test_the_form_offers_what_a_camera_can_see(browser):
    page = browser("therapist").get("/live").text
    for part in (
        'name="camera"',
        'name="person"',
        'name="consent"',
        'value="thesis25"',
        'value="mediapipe21"',
    ):
        assert part in page
    assert 'value="mocap13"' not in page


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("camera", "video:/etc/passwd", "choose it from the list"),
        ("camera", "../take.mcap", "choose it from the list"),
        ("protocol", "/etc/passwd.toml", "one of thesis25"),
        ("protocol", "mocap13", "one of thesis25"),
        ("person", "Anna Nowak", "never a name"),
    ],
)
def test_what_the_form_does_not_offer_is_a_sentence(browser, name, value, words):
    answer = browser("therapist").ask("/live/record", **{**RECORD, name: value})
    assert answer.status_code == 409
    assert words in answer.json()["message"]


def test_the_state_tells_the_shares_of_the_last_second(browser):
    state = browser("therapist").ask("/live/beat", page="x" * 32).json()
    assert {"tracking_percent", "estimated_percent", "lost_percent", "dropped"} <= set(state)
