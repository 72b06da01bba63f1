from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused

THERAPIST = Account("anna", "therapist", "1")
ASSISTANT = Account("bert", "assistant", "2")
PASSWORD = "correct horse battery"


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        yield opened


def test_sign_in_gives_the_account_and_says_nothing_of_which_part_was_wrong(clinic):
    clinic.accounts.add_user("anna", "therapist", PASSWORD, CONSOLE)
    account = clinic.accounts.sign_in("anna", PASSWORD)
    assert (account.name, account.role) == ("anna", "therapist")
    assert clinic.accounts.account("anna") == account
    sentences = set()
    for name, password in (("anna", "wrong password"), ("nobody", PASSWORD)):
        with pytest.raises(Refused) as refusal:
            clinic.accounts.sign_in(name, password)
        sentences.add(str(refusal.value))
    assert len(sentences) == 1


def test_guessing_is_braked(clinic):
    clinic.accounts.add_user("anna", "therapist", PASSWORD, CONSOLE)
    for _ in range(5):
        with pytest.raises(Refused, match="wrong"):
            clinic.accounts.sign_in("anna", "wrong password")
    with pytest.raises(Refused, match="wait"):
        clinic.accounts.sign_in("anna", PASSWORD)


def test_only_administrators_make_accounts(clinic):
    with pytest.raises(Refused, match="may not manage users"):
        clinic.accounts.add_user("eve", "administrator", PASSWORD, THERAPIST)
    with pytest.raises(Refused, match="may not manage users"):
        clinic.accounts.list(ASSISTANT)
    assert clinic.accounts.set_up_needed()


def test_the_console_vouches_for_a_name_only_until_accounts_exist(clinic):
    assert clinic.accounts.at_console("Dr. Who").role == "therapist"
    clinic.accounts.add_user("anna", "therapist", PASSWORD, CONSOLE)
    assert clinic.accounts.at_console("anna").id != CONSOLE.id
    with pytest.raises(Refused, match="one of anna"):
        clinic.accounts.at_console("Dr. Who")
    with pytest.raises(Refused, match="--by"):
        clinic.accounts.at_console(" ")


def test_a_patient_gets_a_pseudonym_and_an_assistant_may_not_add_one(clinic):
    wanted = {"given_name": "Ada", "family_name": "L", "birth_date": "1950-12-31", "side": "left"}
    patient = clinic.patients.add(THERAPIST, **wanted)
    assert patient.id.startswith("P-")
    assert clinic.patients.get(patient.id) == patient
    assert clinic.patients.list() == (patient,)
    with pytest.raises(Refused, match="may not prescribe"):
        clinic.patients.add(ASSISTANT, **wanted)
    with pytest.raises(Refused, match="left or right"):
        clinic.patients.add(THERAPIST, **{**wanted, "side": "both"})
    with pytest.raises(Refused, match=r"0\.10 to 0\.26 m"):
        clinic.patients.add(THERAPIST, **wanted, hand_length_m=1.89)
    with pytest.raises(Refused):
        clinic.patients.get("P-9999")


def test_every_verb_left_a_row_without_a_name_of_a_patient(clinic):
    clinic.accounts.add_user("anna", "therapist", PASSWORD, CONSOLE)
    clinic.accounts.sign_in("anna", PASSWORD)
    clinic.patients.add(
        THERAPIST, given_name="Ada", family_name="Lovelace", birth_date="1950-12-31", side="left"
    )
    rows = clinic.catalogue.audit()
    assert [row.verb for row in reversed(rows)] == ["add user", "sign in", "add patient"]
    assert clinic.catalogue.verify_audit() == 3
    assert not any("Lovelace" in row.detail + row.subject or "Ada" in row.detail for row in rows)


@pytest.mark.parametrize(
    ("field", "value"),
    [("given_name", "x" * 81), ("family_name", "a\x00b"), ("birth_date", "2190-01-01")],
)
def test_a_patient_that_no_screen_can_show_or_no_clinic_can_have_is_refused(clinic, field, value):
    person = {"given_name": "Test", "family_name": "Person", "birth_date": "1957-03-14", "side": "left"}
    clinic.patients.add(THERAPIST, **person)
    with pytest.raises(Refused, match=field.replace("_", " ")):
        clinic.patients.add(THERAPIST, **(person | {field: value}))
    assert len(clinic.patients.list()) == 1
