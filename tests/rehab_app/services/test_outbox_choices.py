"""Lists that offer a few of many while the catalogue does not answer: what it said last, and what waits."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace

import pytest

from rehab_app.errors import NoAnswer
from rehab_app.services.outbox_memory import RememberingCatalogue
from sessions.catalogue import Patient, TakeFilter, TakeWord
from tests.contracts.test_catalogue import take


@pytest.fixture
def room(tmp_path):
    """A catalogue with a patient and an approved take, which was asked for both."""
    with RememberingCatalogue.open(tmp_path) as opened:
        opened.add_patient(Patient(family_name="Lind", side="left"))
        held = opened.add_take(take("a", exercise="fist"))
        opened.approve(held.id, "anna")
        yield opened


@pytest.fixture
def away(room, monkeypatch):
    """Call it, and the server does not answer any more."""

    @contextmanager
    def lost():
        raise NoAnswer("clinic data base", "not answering", "there", "try again")
        yield

    return lambda: monkeypatch.setattr(room, "_answering", lost)


def answers(room):
    return (
        room.recent_patients(20),
        room.find_takes(TakeFilter(approved=True), 0, 20),
        room.take_counts(),
        room.demonstrators(20),
        room.patients_named(("P-0001",)),
        room.lately_treated(),
    )


def test_what_was_said_last_holds(room, away):
    before = answers(room)
    away()
    assert answers(room) == before


def test_nothing_is_made_up_of_what_was_never_asked(room, away):
    away()
    with pytest.raises(NoAnswer):
        room.recent_patients(20)
    with pytest.raises(NoAnswer):
        room.find_patients("lind")


def test_a_take_that_waits_stands_first_where_it_fits(room):
    (held,), _ = room.find_takes(TakeFilter(), 0, 20)
    waiting = replace(take("b", exercise="pinch"), id="b" * 8)
    room._stand_ins = {waiting.id: waiting, waiting.sha256: waiting}
    assert room.find_takes(TakeFilter(), 0, 20) == ((waiting, held), 2)
    assert room.find_takes(TakeFilter(), 20, 20) == ((), 2)
    assert room.find_takes(TakeFilter(words=(TakeWord("bbbb"),)), 0, 20) == ((waiting,), 1)
    assert room.find_takes(TakeFilter(exercise="fist"), 0, 20) == ((held,), 1)
    assert room.find_takes(TakeFilter(approved=False), 0, 20) == ((waiting,), 1)
    assert room.find_takes(TakeFilter(approved=True), 0, 20) == ((held,), 1)
