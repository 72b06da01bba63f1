"""Names stand in one order, and texts are kept or refused in one way, on every engine."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import psycopg
import pytest

from sessions.catalogue import AuditFilter, Catalogue, Exercise, Patient, PatientEntry, User
from sessions.errors import Refused
from tests.contracts.test_catalogue import catalogue, url
from tests.postgres_server import server

__all__ = ["catalogue", "url"]

FAMILY = ("Zanòn", "abate", "Àlvarez", "D'Angelò", "dangelo", "ÉPER", "Rossi", "rossi", "Łuczak", "王")
IN_ORDER = ("abate", "Àlvarez", "D'Angelò", "dangelo", "ÉPER", "Łuczak", "Rossi", "rossi", "Zanòn", "王")
NEVER = ("\0", "\ud800", "x\udfffy")


@pytest.fixture
def italian(tmp_path: Path) -> Iterator[Catalogue]:
    """A data base of PostgreSQL whose own order of texts is not by code point."""
    with psycopg.connect(server().url(), autocommit=True) as connection:
        name = "italian_order"
        connection.execute(f"DROP DATABASE IF EXISTS {name}")
        locale = "LOCALE_PROVIDER icu ICU_LOCALE 'it-IT'"
        connection.execute(f"CREATE DATABASE {name} TEMPLATE template0 ENCODING 'UTF8' {locale}")
    clock = itertools.count(1_790_000_000_000_000_000)
    with Catalogue.open(tmp_path, server().url(name), lambda: next(clock)) as opened:
        yield opened


def check_orders(held: Catalogue) -> None:
    for name in FAMILY:
        held.add_patient(Patient(family_name=name, side="left"))
        held.add_user(User(name=name, role="assistant", password_hash="x"))
        held.add_exercise(Exercise(name=name))
    held.record_audit_rows((name, f"verb {name}", "", "") for name in FAMILY)
    found = [one.family_name for one in held.find_patients()[0]]
    assert found == list(IN_ORDER)
    assert [one.family_name for one in held.find_patients(order="-name")[0]] == found[::-1]
    assert [user.name for user in held.users()] == sorted(FAMILY)
    assert [exercise.name for exercise in held.exercises()] == sorted(FAMILY)
    assert held.audit_words()[0] == frozenset(FAMILY)


def test_names_stand_in_one_order(catalogue: Catalogue) -> None:
    check_orders(catalogue)


def test_names_stand_in_that_order_whatever_the_server_prefers(italian: Catalogue) -> None:
    check_orders(italian)


@pytest.mark.parametrize("typed", ["%", "_", "\\", "100%", "a_b"])
def test_what_stands_for_anything_in_a_query_is_sought_as_it_is(catalogue: Catalogue, typed: str) -> None:
    catalogue.add_patient(Patient(family_name=f"x{typed}y", side="left"))
    catalogue.add_patient(Patient(family_name="100 a-b", side="left"))
    assert [one.family_name for one in catalogue.find_patients(typed)[0]] == [f"x{typed}y"]


def test_a_changed_name_is_found_and_the_old_one_is_not(catalogue: Catalogue) -> None:
    added = catalogue.add_patient(Patient(given_name="Zoë", family_name="Łuczak", side="left"))
    catalogue.change_patient(replace(added, family_name="Ibáñez"))
    assert catalogue.find_patients("luczak")[1] == 0
    assert catalogue.find_patients("zoe IBANEZ")[1] == 1
    catalogue.erase_patient(added.id, "[]", "anna")
    assert catalogue.find_patients("zoe", archived=True)[1] == 0
    assert "zoe" not in str(catalogue.patient_rows(added.id)).lower()


@pytest.mark.parametrize("text", ["x" * 10_000, *NEVER])
def test_a_text_that_no_row_can_hold_is_one_sentence(catalogue: Catalogue, text: str) -> None:
    patient = catalogue.add_patient(Patient(side="left")).id
    acts: tuple[Callable[[], object], ...] = (
        lambda: catalogue.add_patient(Patient(family_name=text, side="left")),
        lambda: catalogue.add_user(User(name=text, role="assistant", password_hash="x")),
        lambda: catalogue.add_exercise(Exercise(name=text)),
        lambda: catalogue.record_audit("anna", "note", text),
        lambda: catalogue.add_entry(
            PatientEntry(patient=patient, kind="note", topic=text, content="{}", by="anna")
        ),
    )
    for act in acts:
        with pytest.raises(Refused) as refusal:
            act()
        assert "\n" not in str(refusal.value)
        assert len(str(refusal.value)) < 300
    assert len(catalogue.patients()) == 1
    assert catalogue.audit() == ()


@pytest.mark.parametrize("text", [*NEVER, "x" * 10_000, "%", "'"])
def test_a_name_that_nobody_can_have_is_unknown(catalogue: Catalogue, text: str) -> None:
    for ask in (catalogue.patient, catalogue.take, catalogue.session, catalogue.user):
        with pytest.raises(Refused, match="unknown"):
            ask(text)
    assert catalogue.find_audit(AuditFilter(subject=text), 0, 10) == ((), 0)
