"""Finding patients: what is typed need not be written as the record is; ten thousand are found at once."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.catalogue import Catalogue, Patient
from sessions.catalogue.search import folded, words_of
from sessions.errors import Refused

PEOPLE = (
    ("Zoë", "Łuczak", "1957-03-14"),
    ("José", "Ibáñez-Ruiz", "1957-03-15"),
    ("Ελένη", "Παπαδοπούλου", "1940-12-01"),
    ("秀英", "王", "1961-01-31"),
    ("فاطمة", "الزهراء", "1972-07-07"),
    ("Jose", "Straße", "1930-02-28"),
)


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    with Catalogue.open(tmp_path_factory.mktemp("people")) as opened:
        for given_name, family_name, born in PEOPLE:
            opened.add_patient(
                Patient(given_name=given_name, family_name=family_name, birth_date=born, side="left")
            )
        yield opened


@pytest.mark.parametrize(
    ("typed", "found"),
    [
        ("", 6),
        ("luczak", 1),
        ("LUCZAK zoe", 1),
        ("Łuczak, Zoë", 1),
        ("jose", 2),
        ("josé ibanez", 1),
        ("strasse", 1),
        ("παπαδοπουλου", 1),
        ("ΕΛΕΝΗ", 1),
        ("王", 1),
        ("فاطمة", 1),
        ("14.3.1957", 1),
        ("14/03/1957 zo", 1),
        ("1957", 2),
        ("p-0004", 1),
        ("zoë jose", 0),
        ("%", 0),
        ("_", 0),
        ("' or 1=1 --", 0),
    ],
)
def test_words_are_found_however_they_are_written(catalogue, typed, found):
    rows, total = catalogue.find_patients(typed)
    assert len(rows) == total == found


def test_orders_turn_round_and_pages_follow_each_other(catalogue):
    by_birth, _ = catalogue.find_patients(order="birth")
    assert [row.birth_date for row in by_birth] == sorted(born for _, _, born in PEOPLE)
    assert catalogue.find_patients(order="-birth")[0] == by_birth[::-1]
    pages = [catalogue.find_patients(order="birth", start=start, count=2) for start in (0, 2, 4, 6)]
    assert sum((rows for rows, _ in pages), ()) == by_birth
    assert {total for _, total in pages} == {6}
    with pytest.raises(Refused, match="order of patients"):
        catalogue.find_patients(order="name; drop table patients")


def test_the_archived_are_found_apart(tmp_path):
    with Catalogue.open(tmp_path) as held:
        kept = held.add_patient(Patient(given_name="A", family_name="B", side="left"))
        held.change_patient(Patient(id=kept.id, given_name="A", family_name="B", side="left", archived=True))
        assert held.find_patients("b")[1] == 0
        assert held.find_patients("b", archived=True)[1] == 1


def test_namesakes_share_the_name_or_the_birth_date(catalogue):
    def ids(*person):
        return [one.family_name for one in catalogue.namesakes(*person)]

    assert ids("ZOE", "luczak", "2001-01-01") == ["Łuczak"]
    assert ids("Ada", "Lovelace", "1957-03-14") == ["Łuczak"]
    assert ids("Ada", "Lovelace", "2001-01-01") == []
    assert ids("", "", "") == []


@given(st.text(max_size=40))
def test_folding_twice_changes_nothing_and_the_form_of_unicode_does_not_matter(text):
    once = folded(text)
    assert folded(once) == once
    assert folded(unicodedata.normalize("NFD", text)) == folded(unicodedata.normalize("NFC", text))


@given(st.text(max_size=30))
def test_a_text_is_found_by_each_of_its_own_words(text):
    assert all(
        word in folded(text.replace(",", " ").replace(";", " ")) for word in words_of(text) if "-" not in word
    )
