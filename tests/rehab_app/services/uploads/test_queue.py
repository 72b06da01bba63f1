"""The queue survives what breaks off, and the server works it off by itself."""

from __future__ import annotations

import random
import threading

import pytest

from rehab_app.access import CONSOLE
from rehab_app.cli.doctor import examine
from rehab_app.config import ClinicFolder
from rehab_app.services.object_queue import Errand, ErrandQueue, StoredMarks
from rehab_app.services.object_worker import UploadWorker, wait_s
from sessions.store.object_trouble import Unreachable

from .conftest import whole


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
