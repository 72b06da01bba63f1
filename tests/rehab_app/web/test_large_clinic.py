"""A page asks the data base the same few questions however much there is, and an index answers them."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import httpx
import pytest
from sqlalchemy import event, text

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.web import create_app
from rehab_app.web.visit import COOKIE
from tests.bench.large_clinic import BUSY, Size, fill
from tests.contracts.test_catalogue import URLS

SIZE = Size(patients=300, sessions=900, takes=40)
_OF_WHO_ASKS = ("FROM audit", "FROM sign_ins", "FROM users", "FROM deliveries")
"""Remembered for some seconds, or written by a thread of their own: how many there are is chance."""
INDEXES = {
    "/patients": "ix_patients_archived_sorted_name",
    "/patients/P-0042": "therapy_sessions_patient",
    "/patients/P-0042/sessions": "takes_subject_id",
    "/sessions": "therapy_sessions_started_utc_ns",
}


@dataclass
class Asked:
    """A clinic behind its pages, and what each page asked the data base."""

    client: httpx.AsyncClient
    runner: asyncio.Runner
    engine: Any
    statements: list[tuple[str, Any]] = field(default_factory=list)

    def page(self, path: str) -> list[tuple[str, Any]]:
        """Questions of a page, the fewest of several openings: what is remembered for seconds adds some."""
        openings = [self._opened(path) for _ in range(5)]
        return min(openings, key=len)

    def _opened(self, path: str) -> list[tuple[str, Any]]:
        self.statements.clear()
        assert self.runner.run(self.client.get(path)).status_code == 200
        return [
            one
            for one in list(self.statements)
            if one[0].startswith("SELECT") and not any(table in one[0] for table in _OF_WHO_ASKS)
        ]

    def plans(self, path: str) -> str:
        """How the data base would answer a page's questions where it may not read whole tables."""
        asked, said = self.page(path), list[str]()
        sqlite = self.engine.dialect.name == "sqlite"
        with self.engine.connect() as connection:
            if not sqlite:
                connection.execute(text("SET LOCAL enable_seqscan = off"))
            for statement, values in asked:
                word = "EXPLAIN QUERY PLAN " if sqlite else "EXPLAIN "
                said += [str(row) for row in connection.exec_driver_sql(word + statement, values)]
        return "\n".join(said)


@pytest.fixture(scope="module", params=sorted(URLS))
def asked(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Asked]:
    folder = tmp_path_factory.mktemp("large")
    url = URLS[request.param](folder)
    with open_clinic(folder, settings=Settings(catalogue_url=url)) as clinic:
        clinic.accounts.add_user("anna", "administrator", "correct horse battery", CONSOLE)
        fill(clinic, url, SIZE)
        app = create_app(clinic, open_viewports=lambda _: None)
        transport = httpx.ASGITransport(app, client=("192.0.2.7", 50000))
        client = httpx.AsyncClient(transport=transport, base_url="http://localhost")
        client.cookies.set(COOKIE, app.state.site.begin("anna"), domain="localhost.local", path="/")
        with asyncio.Runner() as runner:
            made = Asked(client, runner, clinic.catalogue._engine)
            event.listen(
                made.engine,
                "before_cursor_execute",
                lambda *given: made.statements.append((given[2], given[3])),
            )
            yield made
            runner.run(client.aclose())


@pytest.mark.parametrize("tab", ["", "/sessions", "/journal", "/limits", "/progress"])
def test_a_patients_page_asks_as_little_with_200_sessions(asked: Asked, tab: str) -> None:
    few, many = (len(asked.page(f"/patients/{one}{tab}")) for one in ("P-0042", BUSY))
    assert many == few
    assert many < 40


def test_a_list_asks_as_little_of_a_full_page_as_of_one_row(asked: Asked) -> None:
    assert len(asked.page("/patients")) == len(asked.page("/patients?find=p-0042")) < 8
    assert len(asked.page("/sessions")) == len(asked.page("/sessions?page=9999")) - 2 < 6


@pytest.mark.parametrize("path", INDEXES)
def test_an_index_answers(asked: Asked, path: str) -> None:
    assert INDEXES[path] in asked.plans(path)


def test_a_list_by_name_needs_no_sorting(asked: Asked) -> None:
    said = asked.plans("/patients")
    assert "TEMP B-TREE" not in said
    assert "Sort Key: patients" not in said
