"""A backup of every older schema restores onto this program; one of a newer schema is refused whole."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import pytest
from sqlalchemy import create_engine

from rehab_app.bootstrap import open_clinic
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import age, backup_archive
from rehab_app.services.backup_archive import Part, write_archive
from rehab_app.services.backup_key import new_key
from rehab_app.services.restoring import restore
from tests.sessions.catalogue.test_released_schemas import DIGEST, alembic_to, fill

REVISIONS = ("0001", "0002", "0003", "0004", "0005", "0006")
FILE = "clinic.sqlite3"
PASSPHRASE = "a long sentence for the safe"


@pytest.fixture(scope="module")
def key():
    return new_key(PASSPHRASE)


@pytest.fixture
def unlocked(monkeypatch, key, identity):
    """The passphrase's slow half is done once."""
    monkeypatch.setattr(backup_archive, "unlock", lambda locked, passphrase: identity)


@pytest.fixture(scope="module")
def identity(key):
    import base64

    return age.unlock(base64.b64decode(key.locked), PASSPHRASE)


def backup_of(folder, revision, key):
    """A backup as a release of that schema would have made it."""
    source = folder / FILE
    engine = create_engine(f"sqlite:///{source}")
    alembic_to(engine, revision)
    with engine.begin() as connection:
        fill(connection)
    engine.dispose()
    return saved(source, key)


def saved(source, key):
    target = source.with_name("clinic.rehab-backup")
    with target.open("wb") as file:
        write_archive(file, iter([Part(FILE, source)]), key, "0.1", 5)
    return target


@pytest.mark.parametrize("revision", REVISIONS)
@pytest.mark.usefixtures("unlocked")
def test_a_backup_of_an_older_schema_comes_forward(tmp_path, key, revision):
    made = restore(backup_of(tmp_path, revision, key), ClinicFolder(tmp_path / "new"), PASSPHRASE)
    assert made.erased_again == ()
    with open_clinic(tmp_path / "new") as clinic:
        (patient,) = clinic.patients.search("zoe").patients
        assert (patient.id, patient.given_name, patient.version) == ("P-0001", "Zoë", 1)
        assert [row.sha256 for row in clinic.patients.sessions("P-0001")] == [DIGEST]
        assert [user.name for user in clinic.catalogue.users()] == ["anna"]


@pytest.mark.usefixtures("unlocked")
def test_a_backup_of_a_newer_schema_is_refused_whole(tmp_path, key):
    backup_of(tmp_path, "head", key)
    with closing(sqlite3.connect(tmp_path / FILE)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
        connection.commit()
    before = sorted(path.name for path in tmp_path.iterdir())
    with pytest.raises(Refused, match=r"revision 9999.*newer rehab-app") as refusal:
        restore(saved(tmp_path / FILE, key), ClinicFolder(tmp_path / "new"), PASSPHRASE)
    assert "\n" not in str(refusal.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == before
