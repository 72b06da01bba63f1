from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from sqlalchemy import create_engine, inspect

from sessions import catalogue as package
from sessions.catalogue import Catalogue
from sessions.catalogue.tables import Table
from sessions.errors import Refused

MIGRATIONS = Path(package.__file__).parent / "migrations"


def test_migrations_make_exactly_the_tables(tmp_path: Path) -> None:
    Catalogue.open(tmp_path).close()
    assert_exactly_the_tables(tmp_path)


def assert_exactly_the_tables(tmp_path: Path) -> None:
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


def file_at(folder: Path, revision: str) -> sqlite3.Connection:
    """A clinic's data base as an earlier release left it."""
    url = f"sqlite:///{folder / 'clinic.sqlite3'}"
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    engine = create_engine(url)
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
    engine.dispose()
    return sqlite3.connect(folder / "clinic.sqlite3", isolation_level=None)


@pytest.mark.parametrize("revision", ["0001", "0002"])
def test_a_data_base_of_an_earlier_release_keeps_its_content(tmp_path: Path, revision: str) -> None:
    connection = file_at(tmp_path, revision)
    connection.execute("INSERT INTO users VALUES (1, 'anna', 'therapist', 'x', 1, 5)")
    connection.execute("INSERT INTO patients VALUES (1, 'P-0001', '', '', '', 'left', 0.18, '', 0, 5)")
    digest = "a" * 64
    connection.execute(
        f"INSERT INTO takes VALUES ('{digest[:8]}', '{digest}', 'takes/a.mcap', 'left', 'fist', 's', 9.0,"
        " 'T-1', NULL, 5)"
    )
    connection.execute(
        f"INSERT INTO therapy_sessions VALUES ('b', 'P-0001', '{digest[:8]}', '{'b' * 64}', 's/b.mcap',"
        " 'passive', 7)"
    )
    connection.execute(
        f"INSERT INTO prescriptions VALUES (1, 'P-0001', '{digest[:8]}', 'passive', 0.5, 3, 3.0, '', 6)"
    )
    connection.close()
    with Catalogue.open(tmp_path) as catalogue:
        assert [user.name for user in catalogue.users()] == ["anna"]
        (take,) = catalogue.takes()
        assert (take.sha256, take.parent, take.author, take.retouch) == (digest, "", "", "")
        (session,) = catalogue.sessions("P-0001")
        assert (session.take, session.started_utc_ns) == (take.id, 7)
        (ordered,) = catalogue.prescriptions("P-0001")
        assert (ordered.speed, ordered.content, ordered.by) == (0.5, "", "")
        assert catalogue.clinical_records("P-0001") == catalogue.day_limits("P-0001", "exoskeleton") == ()
        assert catalogue.hands("P-0001") == catalogue.calibrations() == ()
    assert_exactly_the_tables(tmp_path)


def test_the_newest_migration_can_be_taken_back(tmp_path: Path) -> None:
    Catalogue.open(tmp_path).close()
    engine = create_engine(f"sqlite:///{tmp_path / 'clinic.sqlite3'}")
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0002")
    with engine.connect() as connection:
        assert "clinical_records" not in inspect(connection).get_table_names()
    engine.dispose()
    Catalogue.open(tmp_path).close()
    assert_exactly_the_tables(tmp_path)
