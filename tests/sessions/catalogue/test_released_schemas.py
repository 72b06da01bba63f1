"""A data base of every released schema comes forward on both engines with all that it held."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from sqlalchemy import Connection, Engine, create_engine, inspect, text

from sessions import catalogue as package
from sessions.catalogue import Catalogue, Patient, Station
from sessions.catalogue.tables import Table
from tests.contracts.test_catalogue import url

__all__ = ["url"]

RELEASED = ("0001", "0002", "0003", "0004")
DIGEST = "a" * 64
ROWS = (
    "INSERT INTO users (id, name, role, password_hash, active, created_utc_ns)"
    " VALUES (1, 'anna', 'therapist', 'x', true, 5)",
    "INSERT INTO patients (number, id, given_name, family_name, birth_date, side, hand_length_m, impairment,"
    " archived, created_utc_ns) VALUES (1, 'P-0001', 'Zoë', '', '', 'left', 0.18, '', false, 5)",
    "INSERT INTO therapy_sessions (id, patient, take, sha256, path, mode, started_utc_ns)"
    f" VALUES ('b', 'P-0001', 't', '{DIGEST}', 's/b.mcap', 'passive', 7)",
)
TAKE = {
    "id": "t",
    "sha256": "b" * 64,
    "path": "takes/t.mcap",
    "side": "left",
    "exercise": "fist",
    "source": "s",
    "duration_s": 9.0,
    "subject_id": "T-1",
    "created_utc_ns": 5,
}


@pytest.fixture
def engine(url: str) -> Iterator[Engine]:
    made = create_engine(url.replace("postgresql:", "postgresql+psycopg:", 1))
    yield made
    made.dispose()


def alembic_to(engine: Engine, revision: str, *, back: bool = False) -> None:
    config = Config()
    config.set_main_option("script_location", str(Path(package.__file__).parent / "migrations"))
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        (command.downgrade if back else command.upgrade)(config, revision)


def differences(engine: Engine) -> list[object]:
    with engine.connect() as connection:
        return list(compare_metadata(MigrationContext.configure(connection), Table.metadata))


def fill(connection: Connection) -> None:
    """Rows as a release of that schema would have written them."""
    columns = [
        column["name"] for column in inspect(connection).get_columns("takes") if not column["nullable"]
    ]
    take = {name: TAKE.get(name, "") for name in columns}
    for row in ROWS[:2]:
        connection.execute(text(row))
    names, values = ", ".join(take), ", ".join(f":{name}" for name in take)
    connection.execute(text(f"INSERT INTO takes ({names}) VALUES ({values})"), take)
    connection.execute(text(ROWS[2]))


@pytest.mark.parametrize("revision", RELEASED)
def test_a_released_schema_comes_forward(engine: Engine, url: str, tmp_path: Path, revision: str) -> None:
    alembic_to(engine, revision)
    with engine.begin() as connection:
        fill(connection)
    with Catalogue.open(tmp_path, url) as catalogue:
        assert [user.name for user in catalogue.users()] == ["anna"]
        patient = catalogue.patient("P-0001")
        assert (patient.given_name, patient.hand_length_m, patient.version) == ("Zoë", 0.18, 1)
        assert [(one.sha256, one.take) for one in catalogue.sessions("P-0001")] == [(DIGEST, "t")]
        assert catalogue.stations() == catalogue.claims() == ()
        catalogue.claim_patient("P-0001", "room-1", "a", 10**12)
        catalogue.say_station(Station(name="room-1", holder="a", version="1"))
        assert [claim.patient for claim in catalogue.claims()] == ["P-0001"]
    assert differences(engine) == []


def test_the_tables_of_stations_can_be_taken_back(engine: Engine, url: str, tmp_path: Path) -> None:
    with Catalogue.open(tmp_path, url) as catalogue:
        patient = catalogue.add_patient(Patient(side="left")).id
        catalogue.claim_patient(patient, "room-1", "a", 10**12)
    alembic_to(engine, "0004", back=True)
    with Catalogue.open(tmp_path, url) as catalogue:
        assert [one.id for one in catalogue.patients()] == [patient]
        assert catalogue.claims() == ()
    assert differences(engine) == []
