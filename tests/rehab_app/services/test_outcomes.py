"""Outcome measures: ranges, units, sides, and what a change means."""

from __future__ import annotations

import math

import pytest

from rehab_app.access import Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.outcome_measures import MEASURES, measure
from rehab_app.web.pages import patient_words

ANNA = Account("anna", "therapist", "1")
WATCH = Account("wim", "auditor", "3")
KEYS = [one.key for one in MEASURES]


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        opened.patients.add(ANNA, given_name="Ada", family_name="L", birth_date="1950-12-31", side="left")
        yield opened


def enter(clinic, key, text, **more):
    chosen = measure(key)
    more = {"side": "left" if chosen.sided else "", "place": next(iter(chosen.places), "")} | more
    return clinic.outcomes.add(ANNA, "P-0001", key, chosen.read(text), **more)


@pytest.mark.parametrize("key", KEYS)
def test_the_ends_of_every_range_are_taken_and_what_lies_beyond_is_not(clinic, key):
    chosen = measure(key)
    for day, value in (("2026-01-01", chosen.low), ("2026-01-02", chosen.high)):
        kept = enter(clinic, key, chosen.text(value), measured_on=day)
        assert kept.value == pytest.approx(value)
    step = chosen.per_shown
    for value in (chosen.low - step, chosen.high + step, math.inf):
        with pytest.raises(Refused, match="must be"):
            chosen.check(value)
    assert len(clinic.outcomes.list("P-0001", key)) == 2


@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("typed", ["", "nan", "inf", "abc", "1e999", "<b>", "x" * 10_000, "１２x"])
def test_what_is_no_number_is_a_sentence(key, typed):
    with pytest.raises(Refused, match="must be") as refusal:
        measure(key).read(typed)
    assert len(str(refusal.value)) < 300


def test_numbers_are_kept_in_si_and_shown_as_typed(clinic):
    assert enter(clinic, "tardieu-r1", "-30,5").value == pytest.approx(math.radians(-30.5))
    assert measure("tardieu-r1").text(math.radians(-30.5)) == "-30.5"
    assert enter(clinic, "grip", "12,4").value == 12.4
    assert enter(clinic, "mas", "1+").value == 1.5
    assert measure("mas").text(1.5) == "1+"
    with pytest.raises(Refused, match=r"one of 0, 1, 1\+, 2, 3, 4"):
        measure("mas").read("1.5")
    with pytest.raises(Refused, match="one of"):
        measure("mas").check(2.5)
    with pytest.raises(Refused, match="whole"):
        measure("arat").read("20.5")


def test_side_and_place_are_stored_never_inferred(clinic):
    with pytest.raises(Refused, match="side"):
        enter(clinic, "grip", "10", side="")
    with pytest.raises(Refused, match="belongs to no single hand"):
        enter(clinic, "quickdash", "10", side="left")
    with pytest.raises(Refused, match="place of Pinch"):
        enter(clinic, "pinch", "3", place="")
    with pytest.raises(Refused, match="place of Grip"):
        enter(clinic, "grip", "3", place="tip")


@pytest.mark.parametrize("day", ["2999-01-01", "1949-12-31", "3.4.2026", "2026-02-30"])
def test_a_date_that_cannot_be_is_refused(clinic, day):
    with pytest.raises(Refused, match="date of the measurement"):
        enter(clinic, "grip", "10", measured_on=day)


def test_one_value_a_day_and_a_correction_takes_its_place(clinic):
    old = enter(clinic, "grip", "10", measured_on="2026-01-01")
    with pytest.raises(Refused, match=f"correct entry {old.id}"):
        enter(clinic, "grip", "11", measured_on="2026-01-01")
    enter(clinic, "grip", "30", measured_on="2026-01-01", side="right")
    new = enter(clinic, "grip", "11", measured_on="2026-01-01", corrects=old.id)
    assert {one.id for one in clinic.outcomes.list("P-0001")} == {new.id, new.id - 1}
    all_rows = {one.id: one.corrected_by for one in clinic.outcomes.list("P-0001", corrected=True)}
    assert all_rows[old.id] == new.id
    with pytest.raises(Refused, match="corrected already"):
        enter(clinic, "grip", "12", measured_on="2026-01-03", corrects=old.id)
    with pytest.raises(Refused, match="unknown"):
        enter(clinic, "arat", "12", corrects=new.id)


def test_a_series_compares_by_the_day_of_measurement_not_of_entry(clinic):
    enter(clinic, "arat", "30", measured_on="2026-03-01")
    enter(clinic, "arat", "10", measured_on="2026-01-01")
    enter(clinic, "arat", "17", measured_on="2026-02-01")
    (one,) = clinic.outcomes.series("P-0001")
    assert [row.value for row in one.rows] == [10, 17, 30]
    assert (one.change, one.since_last, one.direction, one.meaning) == (20, 13, "better", "matters")


@pytest.mark.parametrize(
    ("key", "first", "now", "direction", "meaning"),
    [
        ("arat", "10", "15", "better", "too small to matter"),
        ("arat", "10", "16", "better", "may matter"),
        ("arat", "27", "10", "worse", "matters"),
        ("box-and-block", "20", "26", "better", "matters"),
        ("grip", "10", "15.5", "better", "may matter"),
        ("quickdash", "50", "36", "better", "matters"),
        ("quickdash", "36", "49", "worse", "too small to matter"),
        ("pain-during", "6", "4", "better", "may matter"),
        ("nine-hole-peg", "60", "40", "better", "not known"),
        ("mas", "2", "1+", "better", "not known"),
        ("fma-hand", "7", "7", "same", "not known"),
    ],
)
def test_changes_have_a_direction_and_stand_beside_what_matters(clinic, key, first, now, direction, meaning):
    enter(clinic, key, first, measured_on="2026-01-01")
    (one,) = clinic.outcomes.series("P-0001")
    assert (one.change, one.direction, one.meaning) == (None, "", "")
    enter(clinic, key, now, measured_on="2026-01-02")
    (one,) = clinic.outcomes.series("P-0001")
    assert (one.direction, one.meaning) == (direction, meaning)


def test_hands_and_places_are_series_of_their_own_in_the_order_of_the_measures(clinic):
    enter(clinic, "pinch", "3", place="key")
    enter(clinic, "pinch", "2", place="tip")
    enter(clinic, "grip", "20", side="right")
    enter(clinic, "grip", "10")
    told = [(one.measure.key, one.side, one.place) for one in clinic.outcomes.series("P-0001")]
    assert told == [
        ("grip", "left", ""),
        ("grip", "right", ""),
        ("pinch", "left", "tip"),
        ("pinch", "left", "key"),
    ]


def test_auditors_enter_nothing_and_an_unknown_measure_is_a_sentence(clinic):
    with pytest.raises(Refused, match="may not note"):
        clinic.outcomes.add(WATCH, "P-0001", "quickdash", 10)
    with pytest.raises(Refused, match="one of fma-hand"):
        clinic.outcomes.add(ANNA, "P-0001", "iq", 10)
    with pytest.raises(Refused, match="P-0009"):
        clinic.outcomes.add(ANNA, "P-0009", "quickdash", 10)


def test_the_pages_have_a_word_for_everything():
    words = patient_words
    assert {one.key: one.words for one in MEASURES} == words.MEASURES
    assert {one.key: one.hint for one in MEASURES if one.hint} == words.HINTS
    assert {one.key: one.mcid_words for one in MEASURES if one.mcid_words} == words.MCIDS
    assert {one.shown for one in MEASURES} == set(words.UNITS)
    assert {place for one in MEASURES for place in one.places} == set(words.PLACES)


def test_of_two_at_once_one_value_is_kept(clinic):
    from concurrent.futures import ThreadPoolExecutor

    def once(value):
        try:
            return enter(clinic, "arat", value, measured_on="2026-01-01").id
        except Refused:
            return None

    with ThreadPoolExecutor(4) as threads:
        told = list(threads.map(once, ["10", "11", "12", "13"]))
    assert len([one for one in told if one]) == 1
    assert len(clinic.outcomes.list("P-0001")) == 1
