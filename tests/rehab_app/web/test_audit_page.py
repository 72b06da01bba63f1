"""The audit's page says when all of its chain was followed, and follows it again on demand."""

from __future__ import annotations

import pytest
from sqlalchemy import text

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.web import create_app
from tests.rehab_app.web.conftest import PASSWORD, Browser, NoPictures


@pytest.fixture
def own(tmp_path):
    with open_clinic(tmp_path) as clinic:
        clinic.accounts.add_user("ada", "administrator", PASSWORD, CONSOLE)
        clinic.catalogue.record_audit_rows([("anna", "note", "P-0001", "")] * 150)
        yield clinic


def test_it_says_when_all_was_followed_and_follows_it_on_demand(own):
    ada = Browser(create_app(own, open_viewports=lambda _: NoPictures()), "ada")
    first = ada.get("/clinic/audit").text
    assert "unbroken" in first
    assert "All of it was followed on" in first
    assert "followed since: 0." in first
    own.audit.note(CONSOLE, "add user", "bert")
    assert "followed since: 1." in ada.get("/clinic/audit?person=anna").text
    with own.catalogue._writing() as session:
        session.execute(text("UPDATE audit SET detail = 'nothing' WHERE seq = 3"))
    later = ada.get("/clinic/audit").text  # row 3 is not on this page, and nobody followed it since
    assert "All of it was followed on" in later
    assert 'name="whole" value="yes"' in later
    assert "audit row 3 " in ada.get("/clinic/audit?page=2").text
    assert "audit row 3 " in ada.get("/clinic/audit?whole=yes").text


def test_it_keeps_the_filters_while_all_is_followed(own):
    ada = Browser(create_app(own, open_viewports=lambda _: NoPictures()), "ada")
    page = ada.get("/clinic/audit?person=anna&whole=yes").text
    assert '<input type="hidden" name="person" value="anna">' in page
    assert "followed since: 0." in page
