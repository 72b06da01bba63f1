"""Patients: searched, changed by two people at once, archived; texts of any script."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rehab_app.access import Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused

ANNA = Account("anna", "therapist", "1")
BERT = Account("bert", "assistant", "2")
ADA = {"given_name": "Ada", "family_name": "Lovelace", "birth_date": "1950-12-31", "side": "left"}


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        yield opened


def test_the_later_of_two_who_change_a_record_is_refused_and_the_first_text_stays(clinic):
    read = clinic.patients.add(ANNA, **ADA)
    first = clinic.patients.change(ANNA, replace(read, impairment="weak grip"))
    with pytest.raises(Refused, match="changed by somebody else"):
        clinic.patients.change(ANNA, replace(read, impairment="stiff thumb"))
    assert clinic.patients.get(read.id) == first
    second = clinic.patients.change(ANNA, replace(first, impairment="weak grip, stiff thumb"))
    assert (first.version, second.version) == (2, 3)
    told = clinic.patients.last_change(read.id)
    assert (told.actor, told.detail) == ("anna", "version 3: impairment")


def test_saving_what_stands_there_already_is_no_change(clinic):
    read = clinic.patients.add(ANNA, **ADA)
    assert clinic.patients.change(ANNA, read) == read
    assert clinic.patients.last_change(read.id) is None


def test_a_change_cannot_archive_and_archiving_asks_for_the_role(clinic):
    read = clinic.patients.add(ANNA, **ADA)
    kept = clinic.patients.change(ANNA, replace(read, given_name="Augusta", archived=True))
    assert not kept.archived
    for act in (clinic.patients.archive, clinic.patients.unarchive):
        with pytest.raises(Refused, match="may not prescribe"):
            act(BERT, read.id)
    with pytest.raises(Refused, match="may not prescribe"):
        clinic.patients.change(BERT, kept)
    assert clinic.patients.archive(ANNA, read.id).archived
    assert clinic.patients.list() == ()
    assert clinic.patients.search("ada", archived=True).total == 0
    assert clinic.patients.search("augusta", archived=True).total == 1
    assert clinic.patients.archive(ANNA, read.id).version == clinic.patients.get(read.id).version
    assert not clinic.patients.unarchive(ANNA, read.id).archived


@pytest.mark.parametrize(
    "name", ["Παπαδοπούλου", "王秀英", "فاطمة الزهراء", "שרה", "นภา", "Nguyễn Thị", "می‌خواهم", "O'Néill-Ⅷ"]
)
def test_names_of_any_script_are_kept_in_one_form(clinic, name):
    import unicodedata

    split = unicodedata.normalize("NFD", name)
    kept = clinic.patients.add(ANNA, **(ADA | {"family_name": f"  {split} "}))
    assert kept.family_name == unicodedata.normalize("NFC", name)
    assert clinic.patients.search(name).patients == (kept,)


@pytest.mark.parametrize(
    ("field", "value", "sentence"),
    [
        ("given_name", "a\u202eb", r"U\+202E"),
        ("family_name", "a\x07b", r"U\+0007"),
        ("family_name", "a\nb", r"U\+000A"),
        ("family_name", "x" * 10_000, "10000 characters long"),
        ("impairment", "x" * 10_000, "at most 2000"),
        ("impairment", "a\x00b", r"U\+0000"),
        ("birth_date", "1800-01-01", "birth date"),
        ("birth_date", "19500101", "birth date"),
    ],
)
def test_what_no_screen_can_show_or_nobody_can_be_is_refused_in_a_change_too(clinic, field, value, sentence):
    with pytest.raises(Refused, match=sentence):
        clinic.patients.add(ANNA, **(ADA | {field: value}))
    read = clinic.patients.add(ANNA, **ADA)
    with pytest.raises(Refused, match=sentence):
        clinic.patients.change(ANNA, replace(read, **{field: value}))
    assert clinic.patients.get(read.id) == read


def test_a_note_of_lines_keeps_them(clinic):
    kept = clinic.patients.add(ANNA, **(ADA | {"impairment": "first\r\nsecond\rthird\n"}))
    assert kept.impairment == "first\nsecond\nthird"


def test_pages_of_the_search(clinic):
    for number in range(53):
        clinic.patients.add(ANNA, **(ADA | {"family_name": f"Name{number:02d}"}))
    first, second = clinic.patients.search(), clinic.patients.search(page=2)
    assert (len(first.patients), len(second.patients), second.total, second.pages) == (50, 3, 53, 2)
    assert clinic.patients.search(page=99) == second
    assert clinic.patients.search(page=-4) == first
    with pytest.raises(Refused, match="search"):
        clinic.patients.search("x" * 161)
