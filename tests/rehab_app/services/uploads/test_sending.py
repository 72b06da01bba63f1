"""What was sealed reaches the object store whole, whatever fails."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import asdict, replace

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.errors import Refused
from rehab_app.services.object_opening import open_store
from sessions.store.object_trouble import Unreachable

from .conftest import VIEWER, key, row, seal, whole

STEPS = ("put", "prove", "note", "remove")
KILLED = """
import os, sys
from pathlib import Path
from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.object_queue import ErrandQueue, StoredMarks
from sessions.store.object_store import ObjectStore

step = sys.argv[2]
owner = {"put": ObjectStore, "prove": ObjectStore, "note": StoredMarks, "remove": ErrandQueue}[step]
act = getattr(owner, step)
def then_die(*args):
    act(*args)
    os._exit(9)
setattr(owner, step, then_die)
with open_clinic(Path(sys.argv[1])) as clinic:
    clinic.uploads.push(CONSOLE)
"""


def test_sealed_file_goes_up_and_is_struck_off(clinic, said):
    assert clinic.uploads.gather() == 1
    assert clinic.uploads.waiting() == 1
    done = clinic.uploads.push(CONSOLE)
    assert (done.sent, done.waiting, done.refused) == (1, 0, ())
    assert whole(clinic, said)
    assert asdict(clinic.uploads.status()) == {
        "bucket": "clinic-bucket",
        "to_send": 0,
        "to_delete": 0,
        "stored": 1,
        "trouble": "",
    }


def test_sending_twice_changes_nothing(s3, clinic):
    clinic.uploads.push(CONSOLE)
    changes = len(s3.changes)
    assert clinic.uploads.push(CONSOLE).sent == 0
    assert len(s3.changes) == changes
    assert clinic.uploads.gather() == 0


def test_lost_mark_costs_one_more_proof(clinic):
    clinic.uploads.push(CONSOLE)
    (clinic.folder / "uploads" / "stored.txt").unlink()
    with open_clinic(clinic.folder, settings=clinic.settings) as again:
        assert again.uploads.push(CONSOLE).sent == 1


def test_files_outside_the_catalogue_stay(clinic, take_file):
    """Nothing goes where an erasure would not find it."""
    path = clinic.folder / "sessions" / "stray.mcap"
    shutil.copyfile(take_file, path)
    clinic.uploads.push(CONSOLE)
    assert clinic.uploads.gather() == 0


@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        ("read-only", "closed to this access key"),
        ("wrong key", "access key of the object store is refused"),
        ("hang up", "not answering"),
        ("cut", "object store"),
    ],
)
def test_fault_keeps_the_queue_and_one_pass_ends_it(s3, clinic, said, fault, sentence):
    s3.fault = fault
    before = (clinic.folder / row(clinic).path).read_bytes()
    with pytest.raises(Unreachable, match=sentence):
        clinic.uploads.push(CONSOLE)
    status = clinic.uploads.status()
    assert (status.to_send, status.stored) == (1, 0)
    assert sentence in status.trouble
    assert "\n" not in status.trouble
    s3.fault = ""
    assert clinic.uploads.push(CONSOLE).sent == 1
    assert clinic.uploads.status().trouble == ""
    assert whole(clinic, said)
    assert (clinic.folder / row(clinic).path).read_bytes() == before


def test_missing_bucket(s3, s3_module, clinic):
    with open_clinic(
        clinic.folder, settings=Settings(store=replace(clinic.settings.store, bucket="later-bucket"))
    ) as other:
        with pytest.raises(Unreachable, match="bucket 'later-bucket' is missing"):
            other.uploads.push(CONSOLE)
        s3_module.make_bucket(s3.behind.geturl(), "later-bucket")
        assert other.uploads.push(CONSOLE).sent == 1


@pytest.mark.parametrize("step", STEPS)
def test_kill_at_each_step_loses_nothing(clinic, said, step, tmp_path):
    """Killed after each step of an upload, the next pass finishes it."""
    before = (clinic.folder / row(clinic).path).read_bytes()
    environment = os.environ | {
        "REHAB_STORE_BUCKET": said.bucket,
        "REHAB_STORE_ENDPOINT": said.endpoint,
        "REHAB_STORE_ACCESS_KEY": "k",
        "REHAB_STORE_SECRET_KEY": "s",
    }
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    done = subprocess.run(
        [sys.executable, str(script), str(clinic.folder), step], env=environment, timeout=60, check=False
    )
    assert done.returncode == 9
    assert clinic.uploads.push(CONSOLE).waiting == 0
    assert clinic.uploads.status().stored == 1
    assert whole(clinic, said)
    assert (clinic.folder / row(clinic).path).read_bytes() == before


def test_altered_file_is_named_and_holds_up_nobody(clinic, take_file):
    damaged = clinic.folder / row(clinic).path
    damaged.write_bytes(damaged.read_bytes() + b"x")
    seal(clinic, take_file, "takes")
    done = clinic.uploads.push(CONSOLE)
    assert (done.sent, done.waiting) == (1, 1)
    assert damaged.name in done.refused[0]
    assert done.refused[0] == clinic.uploads.status().trouble


def test_corrupted_object_is_replaced_by_the_proven_file(clinic, said, tmp_path):
    other = tmp_path / "other"
    other.write_bytes(b"not what the name says")
    open_store(said).put(other, key(clinic))
    assert clinic.uploads.push(CONSOLE).sent == 1
    assert whole(clinic, said)


def test_without_a_store_nothing_is_kept(tmp_path):
    with open_clinic(tmp_path / "plain") as clinic:
        assert (clinic.uploads.gather(), clinic.uploads.status().bucket) == (0, "")
        with pytest.raises(Refused, match="object store is not set"):
            clinic.uploads.push(CONSOLE)
        assert not (clinic.folder / "uploads").exists()


def test_roles(clinic):
    for act in (clinic.uploads.push, lambda who: clinic.uploads.evict(who, 0.0)):
        with pytest.raises(Refused):
            act(VIEWER)


def test_one_process_at_a_time(clinic):
    with open_clinic(clinic.folder, settings=clinic.settings) as other, other.uploads._alone():
        with pytest.raises(Refused, match="worked off by another process"):
            clinic.uploads.push(CONSOLE)
