"""A full disk at any byte of a sending or a return loses nothing and is said in one sentence."""

from __future__ import annotations

import os
import random
import resource
from contextlib import contextmanager

import pytest

from rehab_app.access import CONSOLE
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services import storage

from .conftest import VIEWER, row, seal, whole


@contextmanager
def full_at(size_bytes):
    """No file may outgrow a size meanwhile: a write is refused as a full disk refuses it."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def refusal_of(act):
    """The sentence in which it is refused, empty where it is not; any other error is one of the test."""
    try:
        act()
    except REFUSALS as refusal:
        return str(refusal)
    return ""


@pytest.mark.parametrize("seed", range(3))
def test_full_disk_while_sending_loses_nothing_and_the_next_pass_ends_it(clinic, said, tmp_path, seed):
    """Errands, marks and the catalogue: whatever the disk refuses, there is one sentence and no half file."""
    rng, met = random.Random(seed), 0
    for _ in range(8):
        content = tmp_path / "content"
        content.write_bytes(rng.randbytes(2000))
        sealed = seal(clinic, content, "sessions", "P-0001")
        with full_at(int(rng.choice((0, 60, 150, 500, 4096, 60_000)) * rng.random())):
            said_then = refusal_of(lambda: clinic.uploads.push(CONSOLE))
        met += bool(said_then)
        assert "\n" not in said_then
        assert not said_then or said_then.endswith("make room there; what waits is done at the next pass.")
        clinic.uploads.push(CONSOLE)
        assert clinic.uploads.waiting() == 0
        assert storage.digest(clinic.folder / sealed.path) == sealed.sha256
    assert met > 2
    assert whole(clinic, said)
    assert not [name for name in os.listdir(clinic.folder / "uploads") if name.startswith(".put")]


def test_full_disk_on_the_way_back_leaves_nothing(clinic):
    clinic.uploads.push(CONSOLE)
    clinic.uploads.evict(CONSOLE, 0.0)
    path = clinic.folder / row(clinic).path
    with full_at(20_000), pytest.raises(Refused, match="not writable"):
        clinic.uploads.fetch(VIEWER, row(clinic).id)
    assert not path.exists()
    assert not [name for name in os.listdir(path.parent) if "fetching" in name]
