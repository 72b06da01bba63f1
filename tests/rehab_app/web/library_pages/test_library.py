"""Exercises and takes on the pages: found, added, filtered, compared, withdrawn."""

from __future__ import annotations

import re

import pytest

from rehab_app.services.exercises import STARTERS

from ..conftest import ATTACK
from .conftest import ITEM

pytestmark = pytest.mark.usefixtures("recorded")


def test_the_library_shows_every_exercise_with_its_picture(browser):
    visitor = browser("therapist")
    text = visitor.get("/exercises").text
    for one in STARTERS:
        assert f'href="/exercises/{one.name}"' in text
        assert f"/exercise-pictures/{one.name}/{one.view}/right.svg" in text
    picture = visitor.get("/exercise-pictures/wave/palm/left.svg")
    assert picture.headers["content-type"].startswith("image/svg+xml")
    assert picture.text.startswith("<svg")
    assert visitor.get("/exercise-pictures/wave/above/left.svg").status_code == 404


@pytest.mark.parametrize("one", STARTERS, ids=lambda one: one.name)
def test_an_exercise_says_how_it_is_done_and_leads_on(browser, one):
    text = browser("therapist").get(f"/exercises/{one.name}?side=left").text
    assert all(step in text for step in one.instructions)
    assert f"/live?exercise={one.name}#record" in text
    assert f"/exercise-pictures/{one.name}/side/left.svg" in text
    assert 'action="/prescribe"' in text


def test_search_and_purpose_narrow_the_library(browser):
    visitor = browser("therapist")
    found = visitor.get("/exercises?words=hook&purpose=range").text
    assert "/exercises/hook_fist" in found
    assert 'href="/exercises/wave"' not in found
    assert "Nothing fits." in visitor.get("/exercises?words=zebra").text
    assert visitor.get(f"/exercises?words={'x' * 10_000}").status_code == 200


def test_an_own_exercise_is_added_escaped_and_reached_by_any_name(browser):
    visitor = browser("therapist")
    name = f"Öffnen / schließen {ATTACK}"
    answer = visitor.post("/exercises", name=name, description=f"Softly {ATTACK}")
    assert answer.status_code == 303
    shown = visitor.get(answer.headers["location"]).text
    assert ATTACK not in shown
    assert "Öffnen / schließen &lt;img" in shown


@pytest.mark.parametrize("name", ["", "Hook fist", "x" * 10_000])
def test_a_wrong_exercise_comes_back_with_what_was_typed(browser, name):
    answer = browser("therapist").post("/exercises", name=name, description="My own words")
    assert answer.status_code == 409
    assert "name of the exercise" in answer.text
    assert "My own words" in answer.text


def test_takes_are_filtered(browser, recorded):
    visitor = browser("therapist")
    link = f'href="/takes/{recorded.id}"'
    for query in ("exercise=open_close", "side=right&approval=waiting", f"patient={recorded.subject}"):
        assert link in visitor.get(f"/takes?{query}").text
    for query in ("exercise=pinch", "side=left", "approval=approved", "patient=P-0999"):
        text = visitor.get(f"/takes?{query}").text
        assert link not in text
        assert "No take is like this." in text


def test_a_mirrored_take_says_so(browser, recorded):
    text = browser("therapist").get(f"/takes/{recorded.id}").text
    assert "Recorded on the RIGHT hand, will be played mirrored on the LEFT." in text
    assert "14 March 1957" in text
    assert ATTACK not in text


def test_quality_stands_beside_the_take(browser, recorded):
    text = browser("therapist").get(f"/takes/{recorded.id}").text
    assert "How well it was seen" in text
    assert re.search(r"<dt>Measured</dt><dd>\d+ %</dd>", text)


def test_an_approval_is_withdrawn_with_its_reason(browser, library, recorded):
    visitor = browser("therapist")
    visitor.post(f"/takes/{recorded.id}/approve")
    answer = browser("assistant").post(f"/takes/{recorded.id}/withdraw", reason=" ")
    assert answer.status_code == 409
    assert "reason for the withdrawal is empty" in answer.text
    assert library.takes.approval(recorded.id) is not None
    browser("assistant").post(f"/takes/{recorded.id}/withdraw", reason=f"hidden {ATTACK}")
    assert library.takes.approval(recorded.id) is None
    text = visitor.get(f"/takes/{recorded.id}").text
    assert "Approval withdrawn by assistant" in text
    assert "hidden &lt;img" in text
    assert ATTACK not in text


def test_a_retouched_take_is_new_and_compared(browser, library, recorded):
    visitor = browser("therapist")
    answer = visitor.post(
        f"/takes/{recorded.id}/retouch",
        start="0,5",
        end="2.5",
        slow="2",
        digit="index",
        scale="80",
        reason="tired",
    )
    assert answer.status_code == 303, answer.text
    compared = answer.headers["location"]
    row = library.takes.get(compared.split("/")[2])
    assert (row.parent, row.author, row.reason) == (recorded.id, "therapist", "tired")
    assert row.approved_by is None
    text = visitor.get(compared).text
    for sentence in ("Trimmed to 0.50 to 2.50 s.", "Slowed 2 times", "Movement of index scaled to 80 %."):
        assert sentence in text
    svg = visitor.get(f"/takes/{row.id}/joints/compared.svg").text
    assert svg.count("stroke-dasharray") == 15
    assert row.id in visitor.get(f"/takes/{recorded.id}").text
    assert visitor.get(f"/takes/{recorded.id}/compare").status_code == 404


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({}, "retouch is without an operation"),
        ({"start": "x"}, "beginning of the part to keep is"),
        ({"start": "1"}, "end of the part to keep is"),
        ({"start": "1", "end": "99"}, "span of the take is"),
        ({"slow": "50"}, "slowing factor is"),
        ({"scale": "nan"}, "scaling is"),
        ({"digit": "toe", "scale": "50"}, "digit is"),
        ({"smooth": "very"}, "smoothing is"),
        ({"slow": "2", "reason": ""}, "reason"),
    ],
)
def test_a_wrong_retouch_comes_back_with_what_was_typed(browser, library, recorded, fields, sentence):
    before = len(library.takes.list())
    answer = browser("therapist").post(f"/takes/{recorded.id}/retouch", **{"reason": "my reason", **fields})
    assert answer.status_code == 409
    assert sentence in answer.text
    assert all(
        f'value="{value}"' in answer.text
        for name, value in fields.items()
        if value and name in ("start", "end", "slow", "scale")
    )
    assert len(library.takes.list()) == before


def test_devices_and_calibration_are_shown(browser):
    visitor = browser("therapist")
    text = visitor.get("/clinic/devices").text
    assert "Virtual camera" in text
    assert "Exoskeleton (simulation)" in text
    assert "12 driven and measured" in text
    steps = visitor.get("/clinic/calibration").text
    assert "None yet" in steps
    assert "Print the board at 100 % and glue" in steps
    board = visitor.get("/clinic/calibration/board.pdf")
    assert board.content.startswith(b"%PDF")
    assert "attachment" in board.headers["content-disposition"]
    assert visitor.get("/clinic/calibration/board.exe").status_code == 404


@pytest.mark.parametrize("role", ["auditor", "patient"])
def test_who_may_not_treat_changes_nothing(browser, library, recorded, someone, role):
    visitor = browser(role)
    for path in (
        f"/patients/{someone}/plan/item",
        f"/takes/{recorded.id}/withdraw",
        f"/takes/{recorded.id}/retouch",
        "/exercises",
    ):
        assert visitor.post(path, **ITEM).status_code == 403
    assert library.plans.current(someone).version == 0
