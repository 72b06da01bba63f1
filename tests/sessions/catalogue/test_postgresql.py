"""What goes wrong with a data base on a server: one sentence, nothing half written, the next try works."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text

from sessions.catalogue import Catalogue, Patient
from sessions.errors import Refused
from tests.postgres_server import PostgresServer, server

DRIVER = "postgresql+psycopg"


@pytest.fixture
def postgres() -> PostgresServer:
    return server()


def sentence(refused: pytest.ExceptionInfo[Refused]) -> str:
    said = str(refused.value)
    assert "\n" not in said
    return said


@pytest.mark.parametrize("url", ["nonsense", "mysql://host/clinic", "postgresql+pg9000://host/clinic", "://"])
def test_an_address_of_no_engine(tmp_path: Path, url: str) -> None:
    with pytest.raises(Refused, match="catalogue_url") as refused:
        Catalogue.open(tmp_path, url)
    assert "postgresql://" in sentence(refused)


def test_a_wrong_password_is_told_and_not_repeated(tmp_path: Path, postgres: PostgresServer) -> None:
    with pytest.raises(Refused, match="not answering") as refused:
        Catalogue.open(tmp_path, postgres.url(password="wr0ng-one"))
    assert "wr0ng-one" not in sentence(refused)


def test_no_server_and_no_such_data_base(tmp_path: Path, postgres: PostgresServer) -> None:
    for url in (postgres.url("absent"), "postgresql://clinic:x@127.0.0.1:1/clinic"):
        with pytest.raises(Refused, match="not answering") as refused:
            Catalogue.open(tmp_path, url)
        assert "check the server" in sentence(refused)


def test_a_newer_schema_is_left_alone(tmp_path: Path, postgres: PostgresServer) -> None:
    url = postgres.fresh()
    Catalogue.open(tmp_path, url).close()
    engine = create_engine(url.replace("postgresql", DRIVER, 1))
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    engine.dispose()
    with pytest.raises(Refused, match="9999") as refused:
        Catalogue.open(tmp_path, url)
    assert "newer" in sentence(refused)


def test_a_server_that_goes_away_is_told_and_the_next_try_goes_on(tmp_path: Path) -> None:
    own = PostgresServer(server()._binaries)
    try:
        with Catalogue.open(tmp_path, own.fresh()) as catalogue:
            first = catalogue.add_patient(Patient(side="left"))
            own.stop()
            with pytest.raises(Refused, match="not answering") as refused:
                catalogue.add_patient(Patient(side="right"))
            sentence(refused)
            with pytest.raises(Refused, match="not answering"):
                catalogue.patients()
            own.start()
            second = catalogue.add_patient(Patient(side="right"))
            assert [one.id for one in catalogue.patients()] == [first.id, second.id] == ["P-0001", "P-0002"]
            catalogue.verify_audit()
    finally:
        own.remove()


def test_two_stations_may_begin_at_once(tmp_path: Path, postgres: PostgresServer) -> None:
    """Both bring an empty data base to the newest schema, and both write: no number is given twice."""
    url, ids = postgres.fresh(), list[str]()

    def station(number: int) -> None:
        with Catalogue.open(tmp_path / str(number), url) as catalogue:
            for _ in range(10):
                ids.append(catalogue.add_patient(Patient(side="left")).id)
                catalogue.record_audit("anna", "add", ids[-1])

    threads = [threading.Thread(target=station, args=(number,)) for number in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(ids) == [f"P-{number:04d}" for number in range(1, 31)]
    with Catalogue.open(tmp_path, url) as catalogue:
        assert catalogue.verify_audit() >= 30
