"""The record of a patient: who may see it, how it is found, made and changed."""

from __future__ import annotations

import pytest

from rehab_app.access import ROLES, Account

from .conftest import EVENT, FORM, NOTE, PAIN, TABS, edit_form, text_of


@pytest.mark.parametrize("tail", TABS)
@pytest.mark.parametrize("role", ROLES)
def test_pages_ask_for_the_role_and_name_the_patient_completely(browser, at, tail, role):
    answer = browser(role).get(at + tail)
    may = Account(role, role, "1").may("prescribe" if tail == "/edit" else "view")
    assert answer.status_code == (200 if may else 403)
    if may:
        assert answer.text.count("<h1>") == 1
        assert "17 May 19" in answer.text
        assert "Left hand" in answer.text


@pytest.mark.parametrize("role", ROLES)
def test_verbs_ask_for_the_role(browser, at, role):
    verbs = {
        "/edit": "prescribe",
        "/archive": "prescribe",
        "/unarchive": "prescribe",
        "/diagnosis": "prescribe",
        "/unlock": "prescribe",
        "/lock": "view",
        "/outcomes": "note",
        NOTE: "note",
        PAIN: "note",
        EVENT: "note",
    }
    for tail, verb in verbs.items():
        assert (browser(role).post(at + tail).status_code != 403) == Account(role, role, "1").may(verb)
        assert browser().post(at + tail).headers["location"].startswith("/sign-in")


@pytest.mark.parametrize("tail", TABS)
def test_an_unknown_patient_is_a_sentence(browser, tail):
    answer = browser("therapist").get(f"/patients/P-9999{tail}")
    assert answer.status_code == 404
    assert "P-9999" in answer.text


def test_the_list_is_searched_sorted_and_shows_the_archived_on_demand(browser, clinic, at):
    visitor, named = browser("therapist"), clinic.patients.get(at.rsplit("/", 1)[1])
    assert f'href="{at}"' in visitor.get(f"/patients?find={named.family_name.upper()}").text
    assert "Nobody is found" in visitor.get("/patients?find=%3Cscript%3Eqqq").text
    assert "<script>qqq" not in visitor.get("/patients?find=%3Cscript%3Eqqq").text
    assert visitor.get("/patients?order=nonsense").status_code == 404
    assert visitor.get("/patients?page=99999999999").status_code == 200
    visitor.post(f"{at}/archive")
    assert f'href="{at}"' not in visitor.get("/patients").text
    assert f'href="{at}"' in visitor.get("/patients?archived=yes").text
    assert "Archived" in visitor.get(at).text
    visitor.post(f"{at}/unarchive")
    assert f'href="{at}"' in visitor.get("/patients").text


def test_somebody_like_a_patient_is_added_only_after_looking(browser, clinic, at):
    known = clinic.patients.get(at.rsplit("/", 1)[1])
    visitor, before = browser("therapist"), len(clinic.patients.list())
    twin = {**FORM, "given_name": "ADA", "family_name": known.family_name.lower(), "impairment": "typed text"}
    answer = visitor.post("/patients", **twin)
    assert answer.status_code == 409
    assert f'value="{known.id}"' in answer.text
    assert "typed text" in answer.text
    assert visitor.post("/patients", **twin, others="P-9999").status_code == 409
    assert len(clinic.patients.list()) == before
    assert visitor.post("/patients", **twin, others=known.id).status_code == 303
    assert len(clinic.patients.list()) == before + 1


def test_every_wrong_field_is_told_at_once_and_linked(browser, clinic):
    before = len(clinic.patients.list())
    wrong = {**FORM, "given_name": "a\u202eb", "birth_date": "", "hand_length_cm": "400", "side": "both"}
    answer = browser("therapist").post("/patients", **wrong)
    assert answer.status_code == 409
    for field in ("given_name", "birth_date", "hand_length_cm", "side"):
        assert f'href="#{field}"' in answer.text
        assert f'id="{field}-problem"' in answer.text
    assert "400 cm, but must be 10 to 26 cm" in answer.text
    assert len(clinic.patients.list()) == before


@pytest.mark.parametrize("field", ["given_name", "family_name", "impairment"])
def test_ten_thousand_characters_are_a_sentence_and_come_back(browser, clinic, at, field):
    long = "é" * 10_000
    answer = browser("therapist").post(f"{at}/edit", **edit_form(at, clinic, **{field: long}))
    assert answer.status_code == 409
    assert "10000 characters long" in answer.text
    assert long in answer.text


def test_of_two_who_edit_the_later_is_told_and_no_text_is_lost(browser, clinic, at):
    opened = edit_form(at, clinic)
    first, second = browser("therapist"), browser("administrator")
    theirs = {"impairment": "stiff ring finger", "given_name": "Augusta"}
    assert first.post(f"{at}/edit", **{**opened, **theirs}).status_code == 303
    answer = second.post(
        f"{at}/edit",
        **{**opened, "impairment": "weak pinch", "family_name": "Byron", "hand_length_cm": "400"},
    )
    assert answer.status_code == 409
    told = text_of(answer)
    assert "therapist saved this record while you were editing it" in told
    assert "weak pinch stiff ring finger yours: decide" in told
    assert "Augusta theirs, you had not changed it" in told
    assert 'name="family_name" value="Byron"' in answer.text
    assert 'name="given_name" value="Augusta"' in answer.text
    assert "400 cm, but must be" in told
    patient = clinic.patients.get(at.rsplit("/", 1)[1])
    assert (patient.impairment, patient.given_name) == ("stiff ring finger", "Augusta")
    decided = edit_form(at, clinic, family_name="Byron", impairment="stiff ring finger, weak pinch")
    assert second.post(f"{at}/edit", **decided).status_code == 303
    patient = clinic.patients.get(patient.id)
    assert (patient.given_name, patient.family_name) == ("Augusta", "Byron")
    assert patient.impairment == "stiff ring finger, weak pinch"


def test_what_only_one_changed_clashes_with_nobody(browser, clinic, at):
    opened = edit_form(at, clinic)
    visitor = browser("therapist")
    visitor.post(f"{at}/archive")
    visitor.post(f"{at}/unarchive")
    assert visitor.post(f"{at}/edit", **{**opened, "impairment": "new words"}).status_code == 303
    assert clinic.patients.get(at.rsplit("/", 1)[1]).impairment == "new words"


def test_without_a_version_nothing_is_overwritten(browser, clinic, at):
    sent = edit_form(at, clinic, impairment="new words")
    del sent["version"]
    sent = {name: value for name, value in sent.items() if not name.startswith("was_")}
    assert browser("therapist").post(f"{at}/edit", **sent).status_code == 409
    assert clinic.patients.get(at.rsplit("/", 1)[1]).impairment == "first words"
