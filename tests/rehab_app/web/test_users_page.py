"""Users, their passwords and roles; the audit page; the clinic's cards."""

from __future__ import annotations

import csv
import io

import pytest
from sqlalchemy import text

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.web import create_app

from .conftest import ATTACK, PASSWORD, Browser, NoPictures

NEW = "another long sentence"


@pytest.fixture
def own(tmp_path):
    with open_clinic(tmp_path) as opened:
        opened.accounts.set_up("ada", PASSWORD)
        yield opened


@pytest.fixture
def ada(own):
    return Browser(create_app(own, open_viewports=lambda _: NoPictures()), "ada")


def audited(clinic):
    clinic.audit.close()
    return [(row.actor, row.verb, row.subject) for row in clinic.catalogue.audit()]


def test_a_user_is_added_changed_and_closed(own, ada):
    added = ada.post("/clinic/users", name=ATTACK, role="assistant", password=NEW, again=NEW)
    assert added.status_code == 303
    page = ada.get("/clinic/users").text
    assert ATTACK not in page
    assert "&lt;img src=x onerror" in page
    assert ada.post("/clinic/users/role", name=ATTACK, role="therapist").status_code == 303
    assert own.accounts.account(ATTACK).role == "therapist"
    assert ada.post("/clinic/users/password", name=ATTACK, password=PASSWORD).status_code == 303
    assert own.accounts.sign_in(ATTACK, PASSWORD).role == "therapist"
    assert ada.post("/clinic/users/close", name=ATTACK).status_code == 409
    assert ada.post("/clinic/users/close", name=ATTACK, sure="yes").status_code == 303
    with pytest.raises(Refused):
        own.accounts.sign_in(ATTACK, PASSWORD)


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"name": ""}, "1 to 60 characters"),
        ({"name": "x" * 61}, "1 to 60 characters"),
        ({"name": "ADA"}, "already there"),
        ({"name": "a\u202eb"}, "can be shown"),
        ({"password": "short", "again": "short"}, "10 to 200 characters"),
        ({"again": "something else"}, "differ"),
        ({"role": "root"}, "one of administrator"),
    ],
)
def test_a_refused_user_is_shown_again_with_what_was_typed(ada, fields, sentence):
    sent = {"name": "bert", "role": "auditor", "password": NEW, "again": NEW, **fields}
    answer = ada.post("/clinic/users", **sent)
    assert answer.status_code == 409
    assert sentence in answer.text
    assert NEW not in answer.text
    if "role" not in fields:
        assert '<option value="auditor" selected>' in answer.text


def test_the_last_administrator_stays(own, ada):
    for path, fields in (("role", {"role": "therapist"}), ("close", {"sure": "yes"})):
        answer = ada.post(f"/clinic/users/{path}", name="ada", **fields)
        assert answer.status_code == 409
        assert "last administrator" in answer.text
    own.accounts.add_user("eva", "administrator", NEW, CONSOLE)
    assert ada.post("/clinic/users/role", name="ada", role="therapist").status_code == 303


def test_the_own_password_needs_the_old_one(own, ada):
    wrong = {"old_password": "wrong", "new_password": NEW, "again_password": NEW}
    assert ada.post("/account/password", **wrong).status_code == 409
    right = {**wrong, "old_password": PASSWORD}
    assert ada.post("/account/password", **right).status_code == 303
    assert own.accounts.sign_in("ada", NEW).name == "ada"


def test_the_idle_lock_is_a_setting_within_bounds(own, ada):
    for minutes in ("0", "61", "x", ""):
        assert ada.post("/clinic/users/idle", minutes=minutes).status_code == 409
    assert ada.post("/clinic/users/idle", minutes="5").status_code == 303
    assert own.accounts.sign_ins.idle_s() == 300
    assert 'data-idle-s="300"' in ada.get("/account").text


def test_views_refusals_and_sign_outs_are_audited_and_a_reload_is_the_same_view(own):
    own.accounts.add_user("aud", "auditor", PASSWORD, CONSOLE)
    patient = own.patients.add(
        CONSOLE, given_name="Ada", family_name="Lovelace", birth_date="1950-12-31", side="left"
    )
    aud = Browser(create_app(own, open_viewports=lambda _: NoPictures()), "aud")
    for _ in range(3):
        aud.get(f"/patients/{patient.id}")
    aud.get("/patients/P-9999")
    aud.get("/patients/new")
    aud.post("/sign-out")
    rows = audited(own)
    assert rows.count(("aud", "view", patient.id)) == 1
    assert ("aud", "view", "P-9999") not in rows
    assert ("aud", "refused", "/patients/new") in rows
    assert ("aud", "sign out", "") in rows
    assert own.catalogue.verify_audit() == len(rows)


def test_views_are_written_together(own):
    written = []
    before = own.catalogue.record_audit_rows
    own.audit._catalogue.record_audit_rows = lambda rows: written.append(len(rows)) or before(rows)
    ada = own.accounts.account("ada")
    for number in range(40):
        own.audit.note_view(ada, f"P-{number:04d}")
    own.audit.close()
    assert sum(written) == 40
    assert len(written) <= 3


def test_the_audit_page_finds_and_says_whether_the_chain_is_whole(own, ada):
    own.accounts.add_user("bert", "therapist", NEW, CONSOLE)
    own.accounts.change_role("bert", "assistant", own.accounts.account("ada"))
    page = ada.get("/clinic/audit?person=ada").text
    assert "unbroken" in page
    assert "therapist to assistant" in page
    assert "<td><bdi>console</bdi></td>" not in page
    assert "No row fits" in ada.get("/clinic/audit?verb=add+user&until=2001-01-01").text
    assert ada.get("/clinic/audit?from=yesterday").status_code == 400
    assert "therapist to assistant" in ada.get("/clinic/audit?from=2001-01-01&subject=bert").text
    with own.catalogue._writing() as session:
        session.execute(text("UPDATE audit SET detail = 'administrator' WHERE seq = 2"))
    broken = ada.get("/clinic/audit").text
    assert "The chain is broken" in broken
    assert "audit row 2" in broken


def test_the_csv_holds_no_formulas(own, ada):
    own.accounts.add_user("=1+1", "auditor", NEW, CONSOLE)
    answer = ada.get("/clinic/audit.csv?verb=add+user")
    rows = list(csv.DictReader(io.StringIO(answer.content.decode("utf-8-sig"))))
    assert [row["subject"] for row in rows] == ["'=1+1", "ada"]
    assert "attachment" in answer.headers["content-disposition"]


@pytest.mark.parametrize(
    ("role", "shown", "hidden"),
    [
        ("administrator", ("/clinic/users", "/clinic/audit", "/account"), ()),
        ("therapist", ("/account",), ("/clinic/users", "/clinic/audit", "/clinic/backup")),
        ("auditor", ("/clinic/audit",), ("/clinic/users",)),
        ("patient", ("/account",), ("/clinic/audit", "/clinic/devices")),
    ],
)
def test_the_clinic_shows_what_the_role_may_open(browser, role, shown, hidden):
    page = browser(role).get("/clinic").text
    assert all(f'href="{path}"' in page for path in shown)
    assert not any(f'href="{path}"' in page for path in hidden)
