"""A recording that never ends by itself: session after session of random length, told by a shared page."""

from __future__ import annotations

from mmap import mmap
from pathlib import Path

import numpy as np

from sessions.records import JOINTS, Event, JointStates, SessionHeader
from sessions.records.topics import EVENTS, HAND_JOINTS
from sessions.store import SessionReader, SessionWriter

PERIOD_NS = 10_000_000
EVENT_EVERY = 500


class Page:
    """What a recording has told, in memory that outlives it.

    Args:
        memory: Shared memory of at least three integers of 64 bits.
    """

    def __init__(self, memory: mmap) -> None:
        # one store each, so that a kill leaves the old number or the new
        self._told = np.frombuffer(memory, np.int64, 3)

    def tell(self, number: int, rows: int, sealed: int) -> None:
        """Say which session grows, how many rows were written to it, and how many sessions are sealed."""
        if rows == 0:
            self._told[1] = 0  # before the number: rows never belong to a later session
        self._told[0] = number
        self._told[1] = rows
        self._told[2] = sealed

    @property
    def told(self) -> tuple[int, int, int]:
        """The number of the session, its rows, and how many are sealed."""
        number, rows, sealed = self._told.tolist()
        return number, rows, sealed


def record_for_ever(folder: Path, page: Page, first: int, seed: int) -> None:
    """Record sessions ``first``, ``first + 1`` and so on, in session time as fast as the machine can."""
    rng = np.random.default_rng(seed)
    number, sealed = first, 0
    while True:
        page.tell(number, 0, sealed)
        with SessionWriter(name_of(folder, number), header(number)) as writer:
            for row in range(int(rng.integers(1, 1200))):
                record_rows(writer, number, range(row, row + 1))
                page.tell(number, row + 1, sealed)
            writer.seal()
        number, sealed = number + 1, sealed + 1


def record_rows(writer: SessionWriter, number: int, rows: range) -> None:
    """Write rows whose values follow from their places, and an event now and then."""
    for row in rows:
        t_ns = row * PERIOD_NS
        positions_rad = np.full(21, number + 1e-6 * row)
        writer.write(HAND_JOINTS, JointStates(t_ns=t_ns, names=JOINTS, positions_rad=positions_rad))
        if row % EVENT_EVERY == 0:
            writer.write(EVENTS, _event(t_ns, float(row)))


def name_of(folder: Path, number: int) -> Path:
    """Where a session lies once it is sealed."""
    return folder / f"session-{number:06d}.mcap"


def header(number: int) -> SessionHeader:
    """Who, what, when."""
    return SessionHeader(
        session_id=f"{number:032x}",
        kind="take",
        subject_id="p",
        side="right",
        exercise="e",
        source="s",
        software_version="0",
        utc_start_ns=10**18,
        monotonic_start_ns=0,
    )


def check_rows(path: Path, number: int, *, gaps: bool = False) -> int:
    """Rows of a file up to its first gap, each proven to be what was written; 0 where there are none.

    Args:
        path: A sealed file.
        number: Of its session.
        gaps: Whether later rows may be missing.

    Raises:
        AssertionError: A row is missing or was altered.
    """
    with SessionReader(path) as reader:
        assert reader.header.session_id == f"{number:032x}", path.name
        if not reader.counts.get(HAND_JOINTS.name):
            return 0
        columns = reader.columns(HAND_JOINTS)
        events = reader.columns(EVENTS) if reader.counts.get(EVENTS.name) else None
    rows, rest = np.divmod(columns.t_ns, PERIOD_NS)
    assert not rest.any(), path.name
    assert np.all(np.diff(rows) > 0), path.name
    np.testing.assert_array_equal(columns["positions_rad"][:, 20], number + 1e-6 * rows)
    whole = int(np.argmin(np.append(rows == np.arange(rows.size), False)))
    assert gaps or whole == rows.size, f"{path.name} lacks row {whole}"
    if events is not None:
        np.testing.assert_array_equal(events["value"], 1e-7 * events.t_ns)
        np.testing.assert_array_equal(events["value"] % EVENT_EVERY, 0.0)
    return whole


def _event(t_ns: int, value: float) -> Event:
    return Event(
        t_ns=t_ns,
        kind="note",
        severity="info",
        cause="x",
        category="",
        subject="",
        value=value,
        bound=0.0,
        text="",
    )
