"""A patient's account is one patient's screen: it names this patient and exercise, and nobody else's."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rehab_app.access import CONSOLE, ROLES
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.web import create_app

from .conftest import PASSWORD, Browser, NoPictures
from .test_matrix import VERBS, path_of

NAMES = ("Rosalba", "Fiorenzo")


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("own")) as opened:
        for name in NAMES:
            opened.patients.add(
                CONSOLE, given_name=name, family_name="Rossi", birth_date="1950-12-31", side="left"
            )
        take = opened.takes.record_virtual("open_close", "left", 1.5, 3, CONSOLE)
        opened.accounts.set_up("ada", PASSWORD)
        for role in ROLES:
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        yield opened, take.take


@pytest.fixture
def own(held, monkeypatch):
    """The clinic while the first patient practises; patient accounts are nobody's screen."""
    opened, take = held
    opened.accounts.change_role("patient", "patient", CONSOLE)
    now = replace(opened.live.snapshot(), state="playing", patient_id="P-0001", take_id=take)
    monkeypatch.setattr(type(opened.live.snapshot.__self__), "snapshot", lambda _: now)
    return opened


def visitor(clinic, name):
    return Browser(create_app(clinic, open_viewports=lambda _: NoPictures()), name)


def shown(clinic, name):
    screen = visitor(clinic, name)
    state, page = screen.get("/mine/state").json(), screen.get("/mine").text
    assert [state["name"] in page, state["exercise"] in page] == [True, True]
    assert state["name"] or not any(one in page for one in NAMES)
    assert state["step"]
    assert state["going"] is True
    return state["name"], state["exercise"]


@pytest.mark.parametrize("role", ROLES)
def test_no_account_without_a_patient_sees_a_name_or_an_exercise(own, role):
    assert shown(own, role) == ("", "")


def test_the_own_screen_names_the_patient_and_another_patients_screen_does_not(own):
    own.accounts.change_role("patient", "patient", CONSOLE, "P-0001")
    name, exercise = shown(own, "patient")
    assert name == "Rosalba"
    assert exercise
    own.accounts.change_role("patient", "patient", CONSOLE, "P-0002")
    assert shown(own, "patient") == ("", "")


def test_pain_and_stop_work_on_anybodys_screen(own, monkeypatch):
    for patient in ("", "P-0001", "P-0002"):
        own.accounts.change_role("patient", "patient", CONSOLE, patient)
        screen = visitor(own, "patient")
        page = screen.get("/mine").text
        assert 'action="/live/pain"' in page
        assert 'id="stop-button"' in page
        assert screen.ask("/live/pain").status_code not in (401, 403)
        assert screen.ask("/stop").status_code == 200
        own.live.clear_stop(CONSOLE, confirmed=True)


def test_the_users_page_asks_whose_screen_it_is(own):
    ada = visitor(own, "ada")
    added = ada.post(
        "/clinic/users", name="bed 2", role="patient", password=PASSWORD, again=PASSWORD, patient=" p-0002 "
    )
    assert added.status_code == 303
    assert own.accounts.own_patients.of(own.accounts.account("bed 2")) == "P-0002"
    assert 'href="/patients/P-0002"' in ada.get("/clinic/users").text
    ada.post("/clinic/users/role", name="bed 2", role="patient", patient="P-0001")
    assert own.accounts.own_patients.of(own.accounts.account("bed 2")) == "P-0001"
    refused = ada.post("/clinic/users/role", name="bed 2", role="therapist", patient="P-0001")
    assert refused.status_code == 409
    assert "role patient only" in refused.text
    ada.post("/clinic/users/role", name="bed 2", role="therapist")
    ada.post("/clinic/users/role", name="bed 2", role="patient")
    assert own.accounts.own_patients.of(own.accounts.account("bed 2")) == ""


@pytest.mark.parametrize(("role", "patient"), [("patient", "P-0404"), ("therapist", "P-0001")])
def test_a_refused_patient_makes_no_account(own, role, patient):
    sent = {"name": "late", "role": role, "password": PASSWORD, "again": PASSWORD, "patient": patient}
    answer = visitor(own, "ada").post("/clinic/users", **sent)
    assert answer.status_code == 409
    assert f'value="{patient}"' in answer.text
    with pytest.raises(Refused):
        own.accounts.account("late")


def test_only_who_manages_users_ties_and_the_audit_names_no_account_beside_the_patient(own):
    for role in ROLES:
        if role != "administrator":
            with pytest.raises(Refused):
                own.accounts.change_role("patient", "patient", own.accounts.account(role), "P-0001")
    own.accounts.change_role("patient", "patient", CONSOLE, "P-0001")
    own.accounts.change_role("patient", "patient", CONSOLE)
    number = own.accounts.account("patient").id
    rows = [(row.verb, row.subject, row.detail) for row in own.catalogue.audit()]
    assert ("tie screen", "P-0001", f"account {number}") in rows
    assert ("untie screen", "P-0001", f"account {number}") in rows
    assert not any(subject == "patient" and "P-0" in detail for _, subject, detail in rows)


def test_erasing_forgets_the_tie_and_brings_no_older_one_back(tmp_path):
    with open_clinic(tmp_path) as clinic:
        for name in NAMES:
            clinic.patients.add(CONSOLE, given_name=name, family_name="R", birth_date="", side="left")
        clinic.accounts.set_up("ada", PASSWORD)
        bed = clinic.accounts.add_user("bed", "patient", PASSWORD, CONSOLE, "P-0001")
        other = clinic.accounts.add_user("other", "patient", PASSWORD, CONSOLE, "P-0001")
        clinic.accounts.change_role("bed", "patient", CONSOLE, "P-0002")
        clinic.privacy.erasures.erase(CONSOLE, "P-0002", "P-0002")
        assert clinic.accounts.own_patients.of(bed) == ""
        assert clinic.accounts.own_patients.of(other) == "P-0001"
        with clinic.catalogue._reading() as session:
            rows = session.connection().exec_driver_sql("SELECT content FROM settings WHERE key LIKE 'own-%'")
            assert not any("P-0002" in content for (content,) in rows)


def test_archiving_ends_the_tie_and_nobody_is_tied_to_the_archived(tmp_path):
    with open_clinic(tmp_path) as clinic:
        for name in NAMES:
            clinic.patients.add(CONSOLE, given_name=name, family_name="R", birth_date="", side="left")
        clinic.accounts.set_up("ada", PASSWORD)
        bed = clinic.accounts.add_user("bed", "patient", PASSWORD, CONSOLE, "P-0001")
        other = clinic.accounts.add_user("other", "patient", PASSWORD, CONSOLE, "P-0002")
        clinic.patients.archive(clinic.accounts.account("ada"), "P-0001")
        assert clinic.accounts.own_patients.of(bed) == ""
        assert clinic.accounts.own_patients.of(other) == "P-0002"
        with pytest.raises(Refused, match="archived"):
            clinic.accounts.change_role("bed", "patient", CONSOLE, "P-0001")
        clinic.patients.unarchive(CONSOLE, "P-0001")
        assert clinic.accounts.own_patients.of(bed) == ""
        rows = [(row.actor, row.verb, row.subject) for row in clinic.catalogue.audit()]
        assert ("ada", "untie screen", "P-0001") in rows


READS = sorted(line for line in VERBS if line.startswith("GET ") and line != "GET /kept")


@pytest.mark.parametrize("line", READS)
def test_a_patients_account_reads_of_no_patient(own, line):
    """With real numbers in the paths: pages of the own patient are for who treats, too."""
    own.accounts.change_role("patient", "patient", CONSOLE, "P-0002")
    screen = visitor(own, "patient")
    for patient in ("P-0001", "P-0002"):
        path = path_of(line).replace("P-9999", patient).replace("0" * 8, own.takes.list()[0].id)
        answer = screen.get(path)
        assert answer.status_code == (200 if VERBS[line] == "stop" else 403)
        assert not any(name in answer.text for name in ("Rossi", "Rosalba", "1950"))


@pytest.mark.parametrize(
    "path", ["/live/view/", "/review/{take}/view/", "/live", "/live/takes", "/live/patients", "/live/limits"]
)
def test_the_live_picture_is_not_for_a_patients_account(own, path):
    own.accounts.change_role("patient", "patient", CONSOLE, "P-0001")
    answer = visitor(own, "patient").get(path.format(take=own.takes.list()[0].id))
    assert answer.status_code == 403


def test_the_pain_button_of_the_screen_works_without_scripts(own):
    own.accounts.change_role("patient", "patient", CONSOLE, "P-0001")
    answer = visitor(own, "patient").post("/live/pain")
    assert (answer.status_code, answer.headers["location"]) == (303, "/mine")
