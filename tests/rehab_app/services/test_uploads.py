"""What was sealed reaches the object store whole, whatever fails, and leaves it with the patient."""

from __future__ import annotations

import os
import random
import resource
import shutil
import subprocess
import sys
import threading
from dataclasses import asdict, replace

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.doctor import examine
from rehab_app.config import ClinicFolder, Settings, StoreSettings
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.object_opening import open_store
from rehab_app.services.object_queue import Errand, ErrandQueue, StoredMarks
from rehab_app.services.object_worker import UploadWorker, wait_s
from sessions.catalogue import Take, TherapySession
from sessions.store import SessionReader
from sessions.store.object_trouble import Unreachable

VIEWER = Account(name="carla", role="auditor", id="7")
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


def test_waits_double_within_bounds():
    rng = random.Random(3)
    for failures in range(1, 60):
        longest = min(2.0 * 2.0 ** (failures - 1), 600.0)
        assert longest / 2.0 <= wait_s(failures, rng) <= longest


def test_worker_backs_off_and_recovers(s3, clinic):
    told = []
    worker = UploadWorker(clinic.uploads, random.Random(3), lambda good, said: told.append((good, said)))
    s3.fault = "hang up"
    waits = [worker.step() for _ in range(4)]
    assert waits[3] > waits[0]
    s3.fault = ""
    worker.step()
    assert [good for good, _ in told] == [False] * 4 + [True]
    assert clinic.uploads.waiting() == 0


def test_queue_and_marks_survive_torn_lines(tmp_path):
    queue, marks = ErrandQueue(tmp_path), StoredMarks(tmp_path)
    errand = Errand("put", "sessions", "ab" * 32, "sessions/a.mcap")
    queue.add(errand)
    queue.add(errand)
    (queue.folder / ".put-x.77").write_text("torn")
    (queue.folder / "foreign").write_text("")
    assert ErrandQueue(tmp_path).waiting() == (errand,)
    marks.note("sessions", "ab")
    with (queue.folder / "stored.txt").open("a") as file:
        file.write("+sessions/cu")
    assert not StoredMarks(tmp_path).has("sessions", "cu")
    marks.note("takes", "cd")
    fresh = StoredMarks(tmp_path)
    assert fresh.has("sessions", "ab")
    assert fresh.has("takes", "cd")
    marks.forget("sessions", "ab")
    assert not fresh.has("sessions", "ab")


def test_reading_by_id_brings_the_session_back(clinic):
    """Replay and reports ask for a file by its id; that it lies elsewhere is not their concern."""
    clinic.uploads.push(CONSOLE)
    clinic.uploads.evict(CONSOLE, 0.0)
    path = clinic.sessions.path(row(clinic).id)
    assert storage.digest(path) == row(clinic).sha256


def test_full_disk_on_the_way_back_leaves_nothing(clinic):
    clinic.uploads.push(CONSOLE)
    clinic.uploads.evict(CONSOLE, 0.0)
    path = clinic.folder / row(clinic).path
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
    try:
        with pytest.raises(Refused, match="not writable"):
            clinic.uploads.fetch(VIEWER, row(clinic).id)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not path.exists()
    assert not [name for name in os.listdir(path.parent) if "fetching" in name]


def test_doctor_says_what_waits(s3, clinic):
    s3.fault = "hang up"
    with pytest.raises(Unreachable):
        clinic.uploads.push(CONSOLE)
    (found,) = [one for one in examine(ClinicFolder(clinic.folder), 0) if one.name == "object store"]
    assert not found.ok
    assert "not answering" in found.found


def test_thread_of_the_server_sends(clinic, said):
    done = threading.Event()
    worker = UploadWorker(clinic.uploads, random.Random(3), lambda good, said: done.set())
    worker.start()
    assert done.wait(30.0)
    worker.close()
    assert whole(clinic, said)
