"""What the store has proven may leave the disk, comes back, and leaves the store with its patient."""

from __future__ import annotations

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.object_opening import open_store
from sessions.store import SessionReader
from sessions.store.object_trouble import Unreachable

from .conftest import VIEWER, key, row, seal


def test_evicted_session_is_read_in_place_and_fetched(clinic, take_file):
    take = seal(clinic, take_file, "takes")
    clinic.uploads.push(CONSOLE)
    path = clinic.folder / row(clinic).path
    content = path.read_bytes()
    assert clinic.uploads.evict(CONSOLE, 1.0) == ()
    assert clinic.uploads.evict(CONSOLE, 0.0) == (row(clinic).path,)
    assert not path.exists()
    assert (clinic.folder / take.path).exists()
    with clinic.uploads.reading(VIEWER, row(clinic).id) as there, SessionReader(take_file) as here:
        assert there.counts == here.counts
    assert not path.exists()
    assert clinic.uploads.fetch(VIEWER, row(clinic).id).read_bytes() == content
    assert clinic.uploads.push(CONSOLE).sent == 0


def test_nothing_is_evicted_that_is_not_proven_now(s3, clinic, said, tmp_path):
    path = clinic.folder / row(clinic).path
    assert clinic.uploads.evict(CONSOLE, 0.0) == ()
    clinic.uploads.push(CONSOLE)
    spoilt = tmp_path / "spoilt"
    content = bytearray(path.read_bytes())
    content[1000] ^= 4
    spoilt.write_bytes(content)
    open_store(said).replace(spoilt, key(clinic))
    with pytest.raises(Refused, match="SHA-256 of object"):
        clinic.uploads.evict(CONSOLE, 0.0)
    s3.fault = "hang up"
    with pytest.raises(Unreachable):
        clinic.uploads.evict(CONSOLE, 0.0)
    assert path.exists()


def test_erasure_deletes_the_object_also_when_it_was_off_line(s3, clinic, said):
    name = key(clinic)
    clinic.uploads.push(CONSOLE)
    clinic.uploads.evict(CONSOLE, 0.0)
    s3.fault = "hang up"
    clinic.privacy.erasures.erase(CONSOLE, "P-0001", "P-0001")
    with pytest.raises(Unreachable):
        clinic.uploads.push(CONSOLE)
    assert clinic.uploads.status().to_delete == 1
    s3.fault = ""
    with open_clinic(clinic.folder, settings=clinic.settings) as again:
        assert again.uploads.push(CONSOLE).deleted == 1
        assert again.uploads.status().stored == 0
    assert open_store(said).size(name) is None


def test_erasure_before_the_upload_sends_nothing(s3, clinic):
    clinic.uploads.gather()
    clinic.privacy.erasures.erase(CONSOLE, "P-0001", "P-0001")
    done = clinic.uploads.push(CONSOLE)
    assert (done.sent, done.waiting) == (0, 0)
    assert "PUT" not in s3.changes


def test_reading_by_id_brings_the_session_back(clinic):
    """Replay and reports ask for a file by its id; that it lies elsewhere is not their concern."""
    clinic.uploads.push(CONSOLE)
    clinic.uploads.evict(CONSOLE, 0.0)
    path = clinic.sessions.path(row(clinic).id)
    assert storage.digest(path) == row(clinic).sha256
