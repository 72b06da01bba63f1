"""A clinic with years of work in it, seeded and written in bulk: every patient gets what one got by hand."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from sqlalchemy import Connection, Engine, func, insert, select, text
from sqlalchemy import Table as AnyTable

from rehab_app.access import CONSOLE
from rehab_app.services.clinic import Clinic
from rehab_app.services.journal_records import PainReport
from rehab_app.services.plan_items import PlanItem
from sessions.catalogue import AuditRow, ClinicalRecord
from sessions.catalogue.audit import chained
from sessions.catalogue.engine import open_engine
from sessions.catalogue.search import sorted_name, sought_text
from sessions.catalogue.tables import Table
from sessions.reports.past import Kept, Past, past_to_json, past_version

GIVEN = ("Zoë", "José", "Ada", "Ελένη", "秀英", "Åsa", "Nicolò", "Anna")
FAMILY = ("Łuczak", "Rossi", "Ibáñez", "Müller", "Παπάς", "王", "O'Neill", "Straße", "D'Angelò")
MODES = ("passive", "active", "assistive", "resistive")
UTC_NS, DAY_NS = 1_700_000_000_000_000_000, 86_400_000_000_000
BUSY, BUSY_SESSIONS = "P-0001", 200
_ROWS_AT_ONCE = 2000
_COPIED = ("patient_entries", "clinical_records")


@dataclass(frozen=True, slots=True)
class Size:
    """How large the clinic is.

    Attributes:
        patients: Patients.
        sessions: Therapy sessions; 200 of them of the first patient, the others spread over the rest.
        takes: Takes, every second of them approved.
    """

    patients: int
    sessions: int
    takes: int

    @property
    def audit_rows(self) -> int:
        """Two rows of the audit for each session."""
        return 2 * self.sessions


def fill(clinic: Clinic, url: str, size: Size, seed: int = 7) -> None:
    """Fill an empty clinic.

    Args:
        clinic: The clinic; nobody else writes to it meanwhile.
        url: Address of its catalogue.
        size: How large it shall be.
        seed: Of everything that is drawn.
    """
    rng = np.random.default_rng(seed)
    model = _model(clinic)
    engine = open_engine(url)
    try:
        with engine.begin() as connection:
            _write(connection, "takes", _takes(size))
            _write(connection, "approvals", _approvals(size))
            _write(connection, "patients", _patients(size, rng))
            _write(connection, "therapy_sessions", _sessions(size, rng))
            _write(connection, "metric_sets", _numbers(rng))
            for name in _COPIED:
                _write(connection, name, _copies(connection, name, model, size))
            newest = connection.scalar(select(func.max(_table("audit").c.seq))) or 0
            _write(connection, "audit", _audit(clinic.catalogue.audit(1)[0], newest, size, rng))
        _settle(engine)
    finally:
        engine.dispose()


def _model(clinic: Clinic) -> str:
    """A patient whose record, plan and journal were written by the services; the others get the same."""
    added = clinic.patients.add(
        CONSOLE, given_name="Eva", family_name="Lind", birth_date="1960-02-29", side="right"
    )
    clinic.clinical.state(
        CONSOLE, ClinicalRecord(patient=added.id, diagnosis="stroke", event_date="2023-01-10", by="anna")
    )
    item = PlanItem(exercise="open_close", mode="assistive", repetitions=30)
    clinic.plans.change(CONSOLE, replace(clinic.plans.current(added.id), items=(item,), goal="A glass"))
    for number in range(8):
        clinic.journal.note(CONSOLE, added.id, f"Moves better than last week, day {number}.")
        clinic.journal.pain(CONSOLE, added.id, PainReport(score=number, place="wrist"))
        clinic.outcomes.add(
            CONSOLE,
            added.id,
            "box-and-block",
            20.0 + number,
            side="right",
            measured_on=f"2024-01-0{number + 1}",
        )
    return added.id


def _patients(size: Size, rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    for number in range(2, size.patients + 1):
        given = f"{GIVEN[rng.integers(len(GIVEN))]} {number % 97}"
        family = f"{FAMILY[rng.integers(len(FAMILY))]} {number % 313}"
        born = f"19{rng.integers(30, 100)}-0{rng.integers(1, 10)}-1{rng.integers(10)}"
        yield {
            "number": number,
            "id": f"P-{number:04d}",
            "given_name": given,
            "family_name": family,
            "birth_date": born,
            "sorted_name": sorted_name(given, family),
            "sought": sought_text(given, family, born, f"P-{number:04d}"),
            "side": "left" if rng.integers(2) else "right",
            "hand_length_m": 0.18,
            "impairment": "Flexor tone, worse in the cold. " * 6,
            "archived": bool(rng.integers(20) == 0),
            "created_utc_ns": UTC_NS + number,
            "version": 1,
        }


def _takes(size: Size) -> Iterator[dict[str, Any]]:
    for number in range(size.takes):
        sha256 = digest("take", number)
        yield {
            "id": sha256[:12],
            "sha256": sha256,
            "path": f"takes/{number}.mcap",
            "side": "left" if number % 3 else "right",
            "exercise": ("open_close", "pinch", "fist")[number % 3],
            "source": "virtual-camera",
            "duration_s": 12.0,
            "subject_id": f"P-{1 + number % size.patients:04d}" if number % 2 else "T-1",
            "parent": None,
            "author": "",
            "reason": "",
            "retouch": "",
            "created_utc_ns": UTC_NS + number,
        }


def _approvals(size: Size) -> Iterator[dict[str, Any]]:
    for number in range(0, size.takes, 2):
        sha256 = digest("take", number)
        yield {"take": sha256[:12], "by": "anna", "utc_ns": UTC_NS + number, "digest": sha256}


def _sessions(size: Size, rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    others = rng.integers(2, size.patients + 1, size.sessions)
    for number in range(size.sessions):
        sha256 = digest("session", number)
        patient = BUSY if number < BUSY_SESSIONS else f"P-{others[number]:04d}"
        yield {
            "id": sha256[:12],
            "patient": patient,
            "take": digest("take", int(rng.integers(size.takes)))[:12],
            "sha256": sha256,
            "path": f"sessions/{number}.mcap",
            "mode": MODES[1 + number % 3],
            "started_utc_ns": UTC_NS + number * (DAY_NS if number < BUSY_SESSIONS else 600_000_000_000),
        }


def _numbers(rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Numbers of the busy patient's sessions, as measuring would have kept them."""
    for number in range(BUSY_SESSIONS):
        kept = tuple(
            Kept("range_of_motion", joint, float(rng.uniform(0.5, 1.5)), None, None, "ok", "1", "encoder")
            for joint in ("index_pip", "index_mcp_flexion", "middle_pip", "ring_pip", "little_pip")
        )
        sha256 = digest("session", number)
        past = Past(sha256[:12], sha256, BUSY, UTC_NS + number * DAY_NS, "right", "open_close", numbers=kept)
        yield {
            "sha256": sha256,
            "version": past_version(),
            "content": past_to_json(past),
            "created_utc_ns": UTC_NS,
        }


def _copies(connection: Connection, name: str, model: str, size: Size) -> Iterator[dict[str, Any]]:
    table = _table(name)
    rows = connection.execute(select(table).where(table.c.patient == model)).mappings().all()
    for number in range(2, size.patients + 1):
        for row in rows:
            yield {key: value for key, value in row.items() if key != "id"} | {"patient": f"P-{number:04d}"}


def _audit(last: AuditRow, newest: int, size: Size, rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    for number in range(size.audit_rows - newest):
        last = chained(
            last,
            utc_ns=UTC_NS + number,
            actor=f"user{number % 40}",
            verb=("view", "play", "note", "approve")[number % 4],
            subject=f"P-{rng.integers(1, size.patients + 1):04d}",
            detail="",
        )
        yield asdict(last)


def _write(connection: Connection, name: str, rows: Iterator[dict[str, Any]]) -> None:
    for part in _parts(rows):
        connection.execute(insert(_table(name)), part)


def _parts(rows: Iterator[dict[str, Any]]) -> Iterator[Sequence[dict[str, Any]]]:
    while part := list(islice(rows, _ROWS_AT_ONCE)):
        yield part


def _table(name: str) -> AnyTable:
    return Table.metadata.tables[name]


def _settle(engine: Engine) -> None:
    """What the data base's own housekeeping does by itself after a while."""
    with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        connection.execute(text("ANALYZE"))


def digest(kind: str, number: int) -> str:
    """A made-up file's SHA-256."""
    return hashlib.sha256(f"{kind} {number}".encode()).hexdigest()
