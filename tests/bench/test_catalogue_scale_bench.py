"""Pages of a clinic with 10,000 patients and 200,000 sessions on both engines: p95 beside the target."""

from __future__ import annotations

import asyncio
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
import pytest
from sqlalchemy import event

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.web import create_app
from rehab_app.web.visit import COOKIE
from tests.bench.large_clinic import BUSY, Size, fill
from tests.contracts.test_catalogue import URLS

pytestmark = pytest.mark.bench

SIZE = Size(
    patients=int(os.environ.get("REHAB_BENCH_PATIENTS", "10000")),
    sessions=int(os.environ.get("REHAB_BENCH_SESSIONS", "200000")),
    takes=5000,
)
MUST_S = 0.1
ROUNDS = 20
MUST = {
    "search: part of a name": ("/patients?find=luczak",),
    "search: two words": ("/patients?find=zoe+rossi",),
    "search: a pseudonym": ("/patients?find=p-0777",),
    "search: a date": ("/patients?find=14.3.1957",),
    "search: nobody": ("/patients?find=nobody",),
    "everybody, by name": ("/patients", "/patients?order=-name"),
    "everybody, by birth": ("/patients?order=birth", "/patients?order=-birth"),
    "everybody, by side": ("/patients?order=side", "/patients?order=-side"),
    "everybody, by added": ("/patients?order=added", "/patients?order=-added"),
    "everybody, last page": ("/patients?page=99999", "/patients?page=99999&order=added"),
    "archived": ("/patients?archived=yes",),
    "page of a patient": tuple(f"/patients/P-{number:04d}" for number in range(2, 2 + ROUNDS)),
    "page of one with 200 sessions": (f"/patients/{BUSY}",),
    "sessions of a patient": (f"/patients/{BUSY}/sessions", "/patients/P-0042/sessions"),
    "journal of a patient": ("/patients/P-0042/journal",),
    "limits of a patient": ("/patients/P-0042/limits",),
    "live": ("/live", "/live?patient=P-0777"),
    "live: a patient is searched": ("/live/patients?find=luczak", "/live/patients?find=14.3.1957"),
    "live: a take is searched": ("/live/takes?find=pinch+left", "/live/takes?find=rossi"),
    "all takes": ("/takes", "/takes?page=99999", "/takes?exercise=pinch&approval=approved"),
    "takes: search": ("/takes?find=pinch+rossi", "/takes?find=left"),
    "plan of a patient": ("/patients/P-0042/plan", "/patients/P-0042/plan?add=open_close"),
    "an exercise": ("/exercises/open_close",),
}
BESIDE = {
    "progress of 200 sessions": (f"/patients/{BUSY}/progress",),
    "the clinic": ("/clinic",),
    "all sessions": ("/sessions",),
    "the audit": ("/clinic/audit",),
}


@dataclass(frozen=True, slots=True)
class Served:
    """A large clinic behind its pages: the whole application without a socket."""

    engine: str
    client: httpx.AsyncClient
    runner: asyncio.Runner
    statements: list[str]

    def get(self, path: str) -> httpx.Response:
        return self.runner.run(self.client.get(path))


class NoPictures:
    def live_port(self) -> int:
        raise AssertionError("nobody looks at the picture")

    def close(self) -> None:
        pass


@pytest.fixture(scope="module", params=sorted(URLS))
def served(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder: Path = tmp_path_factory.mktemp("large")
    url = URLS[request.param](folder)
    with open_clinic(folder, settings=Settings(catalogue_url=url)) as clinic:
        clinic.accounts.add_user("anna", "administrator", "correct horse battery", CONSOLE)
        begun_s = time.perf_counter()
        fill(clinic, url, SIZE)
        sys.stdout.write(f"\n{request.param}: {SIZE} written in {time.perf_counter() - begun_s:.0f} s\n")
        app = create_app(clinic, open_viewports=lambda _: NoPictures())
        statements: list[str] = []
        event.listen(
            clinic.catalogue._engine,
            "before_cursor_execute",
            lambda *asked: statements.append(asked[2]),
        )
        transport = httpx.ASGITransport(app, client=("192.0.2.7", 50000))
        client = httpx.AsyncClient(transport=transport, base_url="http://localhost")
        client.cookies.set(COOKIE, app.state.site.begin("anna"), domain="localhost.local", path="/")
        with asyncio.Runner() as runner:
            yield Served(request.param, client, runner, statements)
            runner.run(client.aclose())


def p95_s(served: Served, paths: tuple[str, ...], rounds: int) -> tuple[float, float, float, int]:
    """Median and 95th percentile of a page's time by the clock, median of this process's work, statements.

    Times are in s; the statements are those of the last page.
    """
    times_s: list[float] = []
    works_s: list[float] = []
    for number in range(rounds + 1):
        served.statements.clear()
        begun_s, work_s = time.perf_counter(), time.process_time()
        answer = served.get(paths[number % len(paths)])
        times_s.append(time.perf_counter() - begun_s)
        works_s.append(time.process_time() - work_s)
        assert answer.status_code == 200, paths
    late_s = float(np.percentile(times_s[1:], 95))
    return float(np.median(times_s[1:])), late_s, float(np.median(works_s[1:])), len(served.statements)


def test_pages_of_a_large_clinic(served: Served) -> None:
    load = os.getloadavg()[0]
    sys.stdout.write(f"{served.engine}, load {load:.1f}: ms median, p95, of them processor; statements\n")
    for pages, rounds in ((MUST, ROUNDS), (BESIDE, 3)):
        for name, paths in pages.items():
            median_s, late_s, work_s, count = p95_s(served, paths, rounds)
            target = f"must {1e3 * MUST_S:.0f}" if pages is MUST else "        "
            sys.stdout.write(
                f"  {name:32}{1e3 * median_s:8.1f}{1e3 * late_s:8.1f} {target}{1e3 * work_s:8.1f}{count:5}\n"
            )
            sys.stdout.flush()
