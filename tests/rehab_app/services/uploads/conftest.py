"""A clinic with an object store, and what is sealed into it."""

from __future__ import annotations

import shutil

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings, StoreSettings
from rehab_app.services import storage
from rehab_app.services.object_opening import open_store
from sessions.catalogue import Take, TherapySession

VIEWER = Account(name="carla", role="auditor", id="7")


def seal(clinic, take_file, room, patient=""):
    """A sealed file with its digest and its row."""
    name = f"{room}-{len(list((clinic.folder / room).iterdir()))}.mcap"
    path = clinic.folder / room / name
    shutil.copyfile(take_file, path)
    digest = storage.digest(path)
    storage.digest_beside(path).write_text(f"{digest}  {name}\n")
    relative = f"{room}/{name}"
    if room == "takes":
        return clinic.catalogue.add_take(
            Take(
                sha256=digest,
                path=relative,
                side="right",
                exercise="f",
                source="x",
                duration_s=1.0,
                subject_id="T-1",
            )
        )
    row = TherapySession(patient=patient, sha256=digest, path=relative, mode="passive", started_utc_ns=5)
    return clinic.catalogue.add_session(row)


@pytest.fixture
def said(s3):
    return StoreSettings(
        bucket="clinic-bucket", endpoint=s3.url, access_key="k", secret_key="s", timeout_s=5.0
    )


@pytest.fixture
def clinic(tmp_path, said, take_file):
    """A clinic with an object store, one patient and one session that was sealed a moment ago."""
    with open_clinic(tmp_path / "clinic", settings=Settings(store=said)) as clinic:
        clinic.patients.add(CONSOLE, given_name="A", family_name="B", birth_date="1950-01-01", side="left")
        seal(clinic, take_file, "sessions", "P-0001")
        yield clinic


def row(clinic):
    return clinic.catalogue.sessions()[0]


def key(clinic):
    return f"sessions/{row(clinic).sha256}.mcap"


def whole(clinic, said):
    """Whether the store has the session, byte for byte."""
    size = (clinic.folder / row(clinic).path).stat().st_size
    open_store(said).prove(key(clinic), row(clinic).sha256, size)
    return True
