"""A clinic that moves to a server takes every row along, or stays where it is."""

from __future__ import annotations

import itertools
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from sessions.catalogue import Catalogue, Patient, PatientEntry, Setting, Take, TherapySession, User
from sessions.errors import Refused
from tests.postgres_server import server


@pytest.fixture
def clinic(tmp_path: Path) -> Iterator[Catalogue]:
    clock = itertools.count(1_790_000_000_000_000_000, 1000)
    with Catalogue.open(tmp_path / "clinic", "", lambda: next(clock)) as catalogue:
        catalogue.add_user(User(name="anna", role="therapist", password_hash="$argon2id$x"))
        for name in ("Zoë", "李", "o'Neil \\ %s"):
            catalogue.add_patient(
                Patient(given_name=name, family_name="Nowhere", side="left", hand_length_m=0.1837)
            )
        original = catalogue.add_take(take("f"))
        catalogue.add_take(
            take("0", parent=original.id, author="anna", retouch="trim")
        )  # sorts before its parent
        catalogue.add_session(
            TherapySession(
                patient="P-0002",
                take=original.id,
                sha256="b" * 64,
                path="sessions/b.mcap",
                mode="passive",
                started_utc_ns=5,
            )
        )
        catalogue.add_entry(PatientEntry(patient="P-0001", kind="note", content='{"text": "ü"}', by="anna"))
        catalogue.set(Setting(key="x", content="[]", by="anna"))
        for number in range(5):
            catalogue.record_audit("anna", "view", str(number))
        yield catalogue


def take(letter: str, **changes: str) -> Take:
    return Take(
        sha256=letter * 64,
        path=f"takes/{letter}.mcap",
        side="right",
        exercise="fist",
        source="s",
        duration_s=9.25,
        subject_id="T-1",
        **changes,
    )


def test_every_row_arrives_and_the_clinic_goes_on_there(clinic: Catalogue, tmp_path: Path) -> None:
    url = server().fresh()
    moved = {table.name: table for table in clinic.move_to(url)}
    assert moved["patients"].rows == 3
    assert moved["takes"].rows == 2
    assert moved["audit"].rows == 5
    assert all(len(table.sha256) == 64 for table in moved.values())
    with Catalogue.open(tmp_path / "there", url) as there:
        assert there.patients() == clinic.patients()
        assert there.takes() == clinic.takes()
        assert there.sessions() == clinic.sessions()
        assert there.entries("P-0001", ["note"]) == clinic.entries("P-0001", ["note"])
        assert there.verify_audit() == 5
        assert there.add_patient(Patient(side="right")).id == "P-0004"
        assert there.add_entry(PatientEntry(patient="P-0001", kind="note", content="{}", by="anna")).id == 2
        assert there.add_user(User(name="bea", role="assistant", password_hash="x")).id == 2
        there.record_audit("anna", "view", "after")
        assert there.verify_audit() == 6


def test_a_filled_data_base_is_never_mixed_into(clinic: Catalogue) -> None:
    url = server().fresh()
    clinic.move_to(url)
    with pytest.raises(Refused, match="with rows in"):
        clinic.move_to(url)


def test_what_the_server_does_not_take_moves_nothing_and_the_next_try_does(
    clinic: Catalogue, tmp_path: Path
) -> None:
    """SQLite holds a text of any length in a column of 120 characters."""
    url = server().fresh()
    with sqlite3.connect(tmp_path / "clinic" / "clinic.sqlite3") as file:
        file.execute("UPDATE patients SET given_name = ? WHERE id = 'P-0003'", ("x" * 500,))
    with pytest.raises(Refused, match="not accepted"):
        clinic.move_to(url)
    with Catalogue.open(tmp_path / "there", url) as there:
        assert there.patients() == there.users() == ()
    with sqlite3.connect(tmp_path / "clinic" / "clinic.sqlite3") as file:
        file.execute("UPDATE patients SET given_name = 'x' WHERE id = 'P-0003'")
    assert clinic.move_to(url)


def test_a_server_that_does_not_answer(clinic: Catalogue) -> None:
    with pytest.raises(Refused, match="not answering"):
        clinic.move_to("postgresql://clinic:x@127.0.0.1:1/clinic")
