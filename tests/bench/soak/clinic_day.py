"""Hours of clinic at high speed in one served process: what it holds on to is counted after each round.

``python -m tests.bench.soak.clinic_day --hours 8`` takes most of an hour; the suite runs a few rounds. Hours
are hours of recordings and sessions: devices and cameras are simulated, so they pass faster than on the wall.
"""

from __future__ import annotations

import argparse
import csv
import ctypes
import gc
import os
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable
from dataclasses import asdict, astuple, dataclass, fields
from pathlib import Path

import numpy as np

from rehab_app.access import CONSOLE
from rehab_app.services.order import Order
from rehab_app.services.rows import PreparedPlan
from robot_iface.types import Certificate
from tests.bench.web.clinic_under_load import Served, served

NEW_TAKE_EVERY = 8
LIVE_EVERY = 6
TAKE_S = 8.0
LIVE_S = 4.0
PATIENCE_S = 30.0


@dataclass(frozen=True, slots=True)
class Sample:
    """What the process holds after a round, once everybody has left.

    Attributes:
        hours: Simulated time so far.
        memory_mb: Resident memory.
        files: Open file handles.
        threads: Threads.
        beat_p50_ms: Answers to the pages' heartbeat in this round, median.
        beat_p99_ms: The same, 99 %.
        log_mb: Write-ahead log of the catalogue.
    """

    hours: float
    memory_mb: float
    files: int
    threads: int
    beat_p50_ms: float
    beat_p99_ms: float
    log_mb: float


class Day:
    """One served clinic that works.

    Args:
        here: The clinic.
        seed: Of what is recorded.
        minutes: Length of a session.
    """

    def __init__(self, here: Served, seed: int, minutes: float) -> None:
        self._here = here
        self._clinic = here.clinic
        self._seed = seed
        self._minutes = minutes
        self._take = here.take
        self._rehearsed: dict[tuple[str, str], tuple[PreparedPlan, Certificate]] = {}
        self._patient = self._clinic.patients.add(
            CONSOLE, given_name="Ada", family_name="Nowhere", birth_date="1950-01-01", side="right"
        ).id
        self._simulated_s = 0.0

    def round(self, number: int) -> Sample:
        """Record, play, look, report, leave; what is left."""
        with self._here.looked_at(1 + number % 3, read_s=0.05) as figures:
            if number and number % NEW_TAKE_EVERY == 0:
                self._record(number)
            session = self._play(("passive", "assistive")[number % 2])
            if number % LIVE_EVERY == LIVE_EVERY - 1:
                self._play_live()
            self._look_through(session)
        beats_ms = 1e3 * np.concatenate([one["polls_s"] for one in figures])
        return self._sample(beats_ms)

    def _record(self, number: int) -> None:
        made = self._clinic.takes.record_virtual("open_close", "right", TAKE_S, self._seed + number, CONSOLE)
        self._clinic.takes.approve(made.take, CONSOLE)
        self._take = made.take
        self._rehearsed.clear()
        self._simulated_s += TAKE_S

    def _play(self, mode: str) -> str:
        therapy, known = self._clinic.therapy, (mode, self._take)
        if known not in self._rehearsed:
            order = Order(mode=mode, speed=1.0, repetitions=400, minutes=self._minutes)
            plan = therapy.plan(self._take, order, actor=CONSOLE, patient_id=self._patient)
            self._rehearsed[known] = (plan, therapy.rehearse(plan, actor=CONSOLE))
        played = therapy.play(*self._rehearsed[known], actor=CONSOLE)
        self._simulated_s += played.simulated_s
        return played.session

    def _play_live(self) -> None:
        with self._here.operated():
            self._here.play()
            time.sleep(LIVE_S)
            self._here.stop()
        self._simulated_s += LIVE_S

    def _look_through(self, session: str) -> None:
        """As a clinician does: search, patient, review, report, progress; signed in anew and out again."""
        cookie, token = self._here.sign_in()
        pages = (
            "/patients?q=now",
            f"/patients/{self._patient}",
            f"/patients/{self._patient}/progress",
            f"/sessions/{session}",
            f"/sessions/{session}/report",
            "/sessions",
            "/live",
        )
        for page in pages:
            asked = urllib.request.Request(f"http://{self._here.host}{page}", headers={"Cookie": cookie})
            with urllib.request.urlopen(asked, timeout=120.0) as answer:
                answer.read()
        leaving = urllib.request.Request(
            f"http://{self._here.host}/sign-out",
            data=f"form_token={token}".encode(),
            headers={"Cookie": cookie, "Origin": f"http://{self._here.host}"},
        )
        with urllib.request.urlopen(leaving, timeout=30.0) as answer:
            answer.read()

    def _sample(self, beats_ms: np.ndarray) -> Sample:
        gc.collect()
        ctypes.CDLL(None).malloc_trim(0)
        p50_ms, p99_ms = np.percentile(beats_ms, [50, 99])
        log = self._clinic.folder.joinpath("clinic.sqlite3-wal")
        return Sample(
            hours=self._simulated_s / 3600.0,
            memory_mb=resident_mb(),
            files=settled(open_files),
            threads=settled(threads),
            beat_p50_ms=float(p50_ms),
            beat_p99_ms=float(p99_ms),
            log_mb=(log.stat().st_size if log.exists() else 0) / 1e6,
        )


def resident_mb() -> float:
    """Resident memory of this process, MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def open_files() -> int:
    """Open file handles of this process."""
    return len(os.listdir("/proc/self/fd"))


def threads() -> int:
    """Threads of this process."""
    return len(os.listdir("/proc/self/task"))


def settled(count: Callable[[], int]) -> int:
    """The least count within a second in which it no longer falls: connections take a moment to close."""
    least, still_since_s = count(), time.monotonic()
    end_s = still_since_s + PATIENCE_S
    while time.monotonic() < min(still_since_s + 1.0, end_s):
        time.sleep(0.05)
        now = count()
        if now < least:
            least, still_since_s = now, time.monotonic()
    return least


def soak(
    folder: Path,
    hours: float,
    seed: int = 1,
    minutes: float = 5.0,
    told: Callable[[Sample], None] = lambda sample: None,
) -> list[Sample]:
    """Work for so many simulated hours; a sample after each round.

    Args:
        folder: Of the clinic, new.
        hours: Simulated time, h.
        seed: Of what is recorded.
        minutes: Length of one session.
        told: Called with each sample.
    """
    samples: list[Sample] = []
    with served(folder) as here:
        day = Day(here, seed, minutes)
        while not samples or samples[-1].hours < hours:
            samples.append(day.round(len(samples)))
            told(samples[-1])
    return samples


def growth(samples: list[Sample], after_hours: float = 1.0) -> float:
    """Growth of memory after the first hour: the last tenth of the samples over the first tenth, less one.

    Args:
        samples: In their order.
        after_hours: Where the comparison begins; of a shorter run every sample counts.
    """
    kept = np.array([one.memory_mb for one in samples if one.hours >= after_hours] or [samples[0].memory_mb])
    tenth = max(1, kept.size // 10)
    return float(np.median(kept[-tenth:]) / np.median(kept[:tenth]) - 1.0)


def main() -> None:
    """Run it, write every sample, print what grew."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=8.0)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--samples", type=Path, default=Path("build/soak.csv"))
    chosen = parser.parse_args()
    chosen.samples.parent.mkdir(parents=True, exist_ok=True)
    begun_s = time.monotonic()
    with chosen.samples.open("w", newline="") as file, tempfile.TemporaryDirectory() as folder:
        table = csv.writer(file)
        table.writerow([field.name for field in fields(Sample)])

        def told(sample: Sample) -> None:
            table.writerow(astuple(sample))
            file.flush()
            shown = ", ".join(f"{name} {value:.4g}" for name, value in asdict(sample).items())
            sys.stdout.write(f"{shown}\n")
            sys.stdout.flush()

        samples = soak(Path(folder) / "clinic", chosen.hours, chosen.seed, chosen.minutes, told)
    files, tasks = [one.files for one in samples], [one.threads for one in samples]
    sys.stdout.write(
        f"{samples[-1].hours:.2f} h in {(time.monotonic() - begun_s) / 60:.0f} min, {len(samples)} rounds; "
        f"memory after the first hour {100 * growth(samples):+.2f} % (must 2 %); files {files[0]} to "
        f"{files[-1]}, threads {tasks[0]} to {tasks[-1]}\n"
    )


if __name__ == "__main__":
    main()
