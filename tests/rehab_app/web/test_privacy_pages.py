"""Backup and a patient's data in the browser: who may, what is told, what comes out."""

from __future__ import annotations

import io
import zipfile

import pytest

from rehab_app.access import CONSOLE
from rehab_app.services import age


@pytest.fixture
def gone(clinic):
    """A patient that one test erases."""
    return clinic.patients.add(
        CONSOLE, given_name="Zoe", family_name="Erasable", birth_date="1950-01-01", side="left"
    ).id


@pytest.fixture
def key(clinic, monkeypatch):
    """A backup key whose slow half is left out."""
    monkeypatch.setattr(age, "lock", lambda text, passphrase: text.encode())
    clinic.privacy.backups.set_passphrase(CONSOLE, "a long sentence")


@pytest.mark.parametrize(
    ("role", "status"), [("administrator", 200), ("therapist", 403), ("assistant", 403), ("auditor", 403)]
)
def test_backups_are_the_administrators(browser, role, status):
    assert browser(role).get("/clinic/backup").status_code == status
    assert browser(role).post("/clinic/backup/make").status_code in ((303,) if status == 200 else (403,))


def test_two_different_passphrases_are_told(browser, clinic):
    page = browser("administrator")
    answer = page.post("/clinic/backup/passphrase", passphrase="a long sentence", again="another one")
    assert answer.status_code == 303
    assert "typed in two different ways" in page.get("/clinic/backup").text


@pytest.mark.usefixtures("key")
def test_a_backup_is_made_listed_and_downloaded(browser, clinic, tmp_path):
    page = browser("administrator")
    assert page.post("/clinic/backup/place", place=str(tmp_path / "store")).status_code == 303
    assert page.post("/clinic/backup/make").status_code == 303
    (stored,) = clinic.privacy.place.stored()
    assert stored.name in page.get("/clinic/backup").text
    got = page.get(f"/clinic/backup/file/{stored.name}")
    assert got.content == stored.read_bytes()
    assert page.get("/clinic/backup/file/..%2f..%2fsecret").status_code == 404


def test_an_export_is_a_zip_and_leaves_no_copy_on_the_server(browser, clinic, gone):
    got = browser("therapist").post(f"/patients/{gone}/data/export")
    assert got.headers["content-type"] == "application/zip"
    with zipfile.ZipFile(io.BytesIO(got.content)) as archive:
        assert "identity.json" in archive.namelist()
    assert list(clinic.folder.glob(".export-*")) == []
    assert browser("assistant").post(f"/patients/{gone}/data/export").status_code == 403


def test_erasing_wants_the_pseudonym_typed(browser, clinic, gone):
    page = browser("administrator")
    wrong = page.post(f"/patients/{gone}/data/erase", confirmed="P-0000")
    assert wrong.status_code == 409
    assert "type it to erase for good" in wrong.text
    assert clinic.patients.get(gone).family_name == "Erasable"
    assert browser("therapist").post(f"/patients/{gone}/data/erase", confirmed=gone).status_code == 403
    assert page.post(f"/patients/{gone}/data/erase", confirmed=gone).status_code == 303
    assert clinic.patients.get(gone).family_name == ""


def test_consent_is_noted_with_its_author(browser, clinic, patient):
    page = browser("assistant")
    assert page.post(f"/patients/{patient}/data/consent", given="yes", remark="form").status_code == 303
    (stated, *_) = clinic.privacy.consents.history(patient)
    assert (stated.by, stated.consent.given, stated.consent.remark) == ("assistant", True, "form")
    assert "form" in page.get(f"/patients/{patient}/data").text
    assert page.post(f"/patients/{patient}/data/consent").status_code == 409
    assert browser("auditor").post(f"/patients/{patient}/data/consent", given="no").status_code == 403
