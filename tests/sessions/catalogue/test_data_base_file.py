from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import create_engine

from sessions.catalogue import Catalogue, User
from sessions.catalogue.tables import Table
from sessions.errors import Refused


def test_migrations_make_exactly_the_tables(tmp_path: Path) -> None:
    Catalogue.open(tmp_path).close()
    engine = create_engine(f"sqlite:///{tmp_path / 'clinic.sqlite3'}")
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Table.metadata) == []
    engine.dispose()


def test_the_file_is_in_wal_mode(tmp_path: Path) -> None:
    Catalogue.open(tmp_path).close()
    connection = sqlite3.connect(tmp_path / "clinic.sqlite3")
    assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    connection.close()


def test_no_data_base(tmp_path: Path) -> None:
    (tmp_path / "clinic.sqlite3").write_bytes(b"this is no data base, it is a sentence" * 40)
    with pytest.raises(Refused, match="clinic data base"):
        Catalogue.open(tmp_path)


def test_a_newer_data_base(tmp_path: Path) -> None:
    Catalogue.open(tmp_path).close()
    connection = sqlite3.connect(tmp_path / "clinic.sqlite3")
    connection.execute("UPDATE alembic_version SET version_num = '9999'")
    connection.commit()
    connection.close()
    with pytest.raises(Refused, match="newer rehab-app"):
        Catalogue.open(tmp_path)


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "clinic").write_text("x")
    with pytest.raises(Refused, match="clinic folder"):
        Catalogue.open(tmp_path / "clinic")


def test_a_data_base_of_the_first_release_keeps_its_content(tmp_path: Path) -> None:
    with Catalogue.open(tmp_path) as catalogue:
        added = catalogue.add_user(User(name="anna", role="therapist", password_hash="x"))
    connection = sqlite3.connect(tmp_path / "clinic.sqlite3")
    connection.executescript(
        "DROP TABLE hands; DROP TABLE camera_calibrations; UPDATE alembic_version SET version_num = '0001';"
    )
    connection.close()
    with Catalogue.open(tmp_path) as catalogue:
        assert catalogue.users() == (added,)
        assert catalogue.calibrations() == ()
        assert catalogue.hands("P-0001") == ()
