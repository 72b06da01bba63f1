"""Re-analysis: the same numbers whoever measures, resumable, one bad file stops none of the others."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services import kept_numbers
from rehab_app.services.kept_numbers import KeptNumbers
from rehab_app.services.recompute import Recompute
from rehab_app.services.recompute_crew import dask_crew
from rehab_app.services.recompute_run import measure_with
from rehab_app.services.recompute_work import Work, measured
from sessions.catalogue import TherapySession
from sessions.reports.past import past_version
from tests.rehab_app.services.recorded_sessions import UTC_NS, add_sessions

FILES = 5


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("clinic")) as opened:
        add_sessions(opened, FILES)
        yield opened


@pytest.fixture(scope="module")
def alone(clinic):
    """What one worker of this machine finds; everything is kept after it."""
    return clinic.recompute.run(CONSOLE, None, workers=1)


class Forgetful(KeptNumbers):
    """Numbers of nobody yet: what it keeps, it keeps for itself."""

    def __init__(self, folder, catalogue):
        super().__init__(folder, catalogue)
        self.kept = {}

    def texts(self, works):
        return {work.sha256: self.kept[work.sha256] for work in works if work.sha256 in self.kept}

    def keep(self, answer):
        found = super().keep(answer)
        if not isinstance(found, str):
            self.kept[answer.work.sha256] = answer.content
        return found


def anew(clinic):
    from rehab_app.config import resolve_folder

    numbers = Forgetful(resolve_folder(clinic.folder), clinic.catalogue)
    return Recompute(clinic.catalogue, numbers, clinic.audit, clinic.settings.recompute)


def test_everything_is_measured_once(clinic, alone):
    assert (alone.files, alone.kept, alone.measured, alone.troubles) == (FILES, 0, FILES, ())
    again = clinic.recompute.run(CONSOLE, None, workers=1)
    assert (again.kept, again.measured) == (FILES, 0)
    assert again.digest == alone.digest


def test_two_workers_find_what_one_finds(clinic, alone):
    told = []
    both = anew(clinic).run(CONSOLE, None, workers=2, told=lambda done, total: told.append((done, total)))
    assert both.measured == FILES
    assert both.digest == alone.digest
    assert told == [(done, FILES) for done in range(FILES + 1)]


def test_a_cluster_finds_what_one_worker_finds(clinic, alone):
    distributed = extra_dask()
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        found = anew(clinic).run(CONSOLE, None, scheduler=cluster.scheduler_address)
    assert found.measured == FILES
    assert found.digest == alone.digest


def extra_dask():
    if os.environ.get("CI"):
        import distributed

        return distributed
    return pytest.importorskip("distributed", reason="the extra dask is not installed")


def test_progress_reads_what_was_kept(clinic, alone, monkeypatch):
    from rehab_app.services import progress

    def never(_):
        raise AssertionError("measured again")

    monkeypatch.setattr(progress, "measured_all", never)
    patient = clinic.catalogue.sessions()[0].patient
    assert alone.measured == FILES
    assert len(clinic.progress.of_patient(patient).pasts) == FILES


def test_another_version_is_measured_again(clinic, alone, monkeypatch):
    monkeypatch.setattr(kept_numbers, "past_version", lambda: "past-of-tomorrow")
    works = KeptNumbers.works(clinic.recompute._numbers, clinic.catalogue.sessions())
    assert {work.key for work in works} == {"past-of-tomorrow"}
    assert clinic.recompute._numbers.texts(works) == {}
    assert alone.version == past_version()


def test_a_worker_of_another_version_is_not_believed(clinic):
    work = clinic.recompute._works(None)[0]
    answer = replace(measured(work), version="past-of-yesterday")
    assert "another version" in clinic.recompute._numbers.keep(answer)


def test_the_digest_of_one_metric_is_of_that_metric(clinic, alone):
    one = clinic.recompute.run(CONSOLE, None, metric="range_of_motion", workers=1)
    other = clinic.recompute.run(CONSOLE, None, metric="repetitions", workers=1)
    assert len({alone.digest, one.digest, other.digest}) == 3


def test_named_sessions_only(clinic, alone):
    ids = [row.id for row in clinic.catalogue.sessions()][:2]
    assert clinic.recompute.run(CONSOLE, ids, workers=1).files == 2
    with pytest.raises(Refused, match="nothing-like-it unknown"):
        clinic.recompute.run(CONSOLE, [*ids, "nothing-like-it"])
    with pytest.raises(Refused, match="none named"):
        clinic.recompute.run(CONSOLE, [])
    with pytest.raises(Refused, match="beauty"):
        clinic.recompute.run(CONSOLE, None, metric="beauty")
    with pytest.raises(Refused, match="assistant"):
        clinic.recompute.run(Account("kim", "assistant", "2"), None)


def test_bad_files_are_told_and_stop_no_other(tmp_path):
    with open_clinic(tmp_path) as clinic:
        good = add_sessions(clinic, 3)
        patient = clinic.catalogue.sessions()[0].patient
        paths = {row.id: tmp_path / row.path for row in clinic.catalogue.sessions()}
        paths[good[0]].write_bytes(paths[good[0]].read_bytes()[:5000])
        paths[good[1]].write_bytes(paths[good[2]].read_bytes())
        gone = clinic.catalogue.add_session(
            TherapySession(
                patient=patient,
                sha256="a" * 64,
                path="sessions/gone.mcap",
                mode="passive",
                started_utc_ns=UTC_NS,
            )
        )
        found = clinic.recompute.run(CONSOLE, None, workers=2)
        assert found.measured == 1
        assert {trouble.id for trouble in found.troubles} == {good[0], good[1], gone.id}
        reasons = {trouble.id: trouble.reason for trouble in found.troubles}
        assert "not the one that was sealed" in reasons[good[1]]
        assert "no such file" in reasons[gone.id]
        again = clinic.recompute.run(CONSOLE, None, workers=2)
        assert (again.kept, again.troubles) == (1, found.troubles)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "http://127.0.0.1:9"])
def test_an_unreachable_scheduler_is_one_sentence_in_ten_seconds(clinic, address):
    extra_dask()
    begun = time.monotonic()
    with pytest.raises(Refused, match="no scheduler that answers"):
        anew(clinic).run(CONSOLE, None, scheduler=address)
    assert time.monotonic() - begun < 10.0


def test_without_the_extra_it_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(Refused, match="install the extra dask"), dask_crew("tcp://127.0.0.1:9"):
        pass


class Deadly(Path):
    """A path that ends the process that reads it."""

    _flavour = type(Path())._flavour

    def __fspath__(self):
        os.kill(os.getpid(), signal.SIGKILL)


def test_a_file_that_kills_its_process_costs_no_other_file(clinic):
    from rehab_app.services.recompute_crew import local_crew

    works = clinic.recompute._works(None)
    deadly = Work("deadly", "d" * 64, works[0].key, Deadly("deadly.mcap"))
    answers = list(measure_with([works[0], deadly, *works[1:]], lambda: local_crew(2)))
    told = {answer.work.id: answer.refusal for answer in answers}
    assert "its process died" in told.pop("deadly")
    assert told == {work.id: "" for work in works}


KILLED = """
import os, signal, sys
from pathlib import Path
from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic

def told(done, total):
    if done == int(sys.argv[2]):
        os.kill(os.getpid(), signal.SIGKILL)

if __name__ == "__main__":
    with open_clinic(Path(sys.argv[1])) as clinic:
        clinic.recompute.run(CONSOLE, None, workers=2, told=told)
"""


def test_a_kill_loses_only_what_was_in_flight(tmp_path, clinic, alone):
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    with open_clinic(tmp_path / "clinic") as other:
        add_sessions(other, FILES)
        done = subprocess.run(
            [sys.executable, script, other.folder, "2"], timeout=60, check=False, capture_output=True
        )
        assert done.returncode == -signal.SIGKILL, done.stderr.decode()
        rest = other.recompute.run(CONSOLE, None, workers=1)
        assert (rest.kept, rest.measured, rest.troubles) == (2, FILES - 2, ())
        assert rest.digest == alone.digest
