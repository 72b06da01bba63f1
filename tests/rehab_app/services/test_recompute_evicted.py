"""Re-analysis reads what only the object store has, and leaves the disk as it was."""

from __future__ import annotations

from pathlib import Path

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings, StoreSettings
from tests.rehab_app.services.recorded_sessions import add_sessions

FILES = 3


@pytest.fixture
def clinic(tmp_path, s3):
    said = StoreSettings(
        bucket="clinic-bucket", endpoint=s3.url, access_key="k", secret_key="s", timeout_s=5.0
    )
    with open_clinic(tmp_path / "clinic", settings=Settings(store=said)) as opened:
        add_sessions(opened, FILES)
        opened.uploads.push(CONSOLE)
        yield opened


def recordings(clinic):
    return sorted(Path(clinic.folder / "sessions").glob("*.mcap"))


def test_evicted_sessions_are_measured_as_if_they_were_here(clinic, tmp_path):
    with open_clinic(tmp_path / "twin") as twin:
        add_sessions(twin, FILES)
        expected = twin.recompute.run(CONSOLE, None, workers=1)
    assert len(clinic.uploads.evict(CONSOLE, 0.0)) == FILES
    assert recordings(clinic) == []
    found = clinic.recompute.run(CONSOLE, None, workers=1)
    assert (found.measured, found.troubles) == (FILES, ())
    assert found.digest == expected.digest
    assert recordings(clinic) == []


def test_a_store_that_does_not_answer_costs_only_what_it_alone_has(clinic, s3):
    clinic.uploads.evict(CONSOLE, 0.0)
    first, *others = clinic.catalogue.sessions()
    clinic.uploads.fetch(CONSOLE, first.id)
    kept = recordings(clinic)
    s3.fault = "wrong key"
    found = clinic.recompute.run(CONSOLE, None, workers=1)
    assert found.measured == 1
    assert {trouble.id for trouble in found.troubles} == {row.id for row in others}
    assert [trouble.reason for trouble in found.troubles if "bucket" not in trouble.reason] == []
    assert recordings(clinic) == kept
    s3.fault = ""
    again = clinic.recompute.run(CONSOLE, None, workers=1)
    assert (again.kept, again.measured, again.troubles) == (1, FILES - 1, ())
