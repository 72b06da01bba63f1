"""Every verb leaves a row in the hash-chained audit; a stop's row is written behind it, never before."""

from __future__ import annotations

import csv
import io
import queue
import threading
import time
from collections.abc import Iterable
from datetime import UTC, datetime
from queue import SimpleQueue
from typing import TypeAlias

from rehab_app.access import Account, require
from rehab_app.services.audit_chain import AuditChain, ChainState
from sessions.catalogue import AuditFilter, AuditRow, Catalogue

VIEW = "view"
LONGEST_CSV = 200_000
_GATHER_S = 1.0
_MOST_AT_ONCE = 500
_SAME_VIEW_S = 60.0
_MOST_VIEWS = 2048
_RISKY = ("=", "+", "-", "@", "\t", "\r")
_Waiting: TypeAlias = tuple[str, str, str, str]


class Audit:
    """Writes audit rows, and reads them for those who may.

    Args:
        catalogue: The clinic's catalogue.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._chain = AuditChain(catalogue)
        self._words: tuple[frozenset[str], frozenset[str], int] = (frozenset(), frozenset(), 0)
        self._later: SimpleQueue[_Waiting | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._viewed: dict[tuple[str, str, str], float] = {}

    def note(self, actor: Account, verb: str, subject: str = "", detail: str = "") -> None:
        """Write a row now."""
        self._catalogue.record_audit(actor.name, verb, subject, detail)

    def note_later(self, actor: str, verb: str, subject: str = "", detail: str = "") -> None:
        """Write a row from another thread; the caller waits for nothing."""
        self._later.put((actor, verb, subject, detail))

    def note_view(self, actor: Account, subject: str, detail: str = "") -> None:
        """Somebody looked at something; the same look within a minute (a reload) is the same view.

        Rows of views are written together, once a second, so that a page costs no write of its own.
        """
        key, now_s = (actor.name, subject, detail), time.monotonic()
        if now_s - self._viewed.get(key, -_SAME_VIEW_S) < _SAME_VIEW_S:
            return
        if len(self._viewed) >= _MOST_VIEWS:
            self._viewed.clear()
        self._viewed[key] = now_s
        self.note_later(actor.name, VIEW, subject, detail)

    def find(
        self, actor: Account, wanted: AuditFilter, start: int = 0, count: int = 100
    ) -> tuple[tuple[AuditRow, ...], int]:
        """Rows that fit, newest first, and how many fit in all.

        Raises:
            Refused: The actor may not read the audit.
        """
        require(actor, "audit")
        return self._catalogue.find_audit(wanted, start, count)

    def words(self, actor: Account) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Persons and verbs that the audit knows, in order: those known before and those of rows added since.

        Raises:
            Refused: The actor may not read the audit.
        """
        require(actor, "audit")
        persons, verbs, newest = self._words
        more_persons, more_verbs, newest = self._catalogue.audit_words(newest)
        self._words = (persons | more_persons, verbs | more_verbs, newest)
        return tuple(sorted(self._words[0])), tuple(sorted(self._words[1]))

    def csv(self, actor: Account, wanted: AuditFilter) -> str:
        """The rows that fit as CSV, newest first; leaves a row itself.

        Raises:
            Refused: The actor may not read the audit.
        """
        require(actor, "audit")
        rows, _ = self._catalogue.find_audit(wanted, 0, LONGEST_CSV)
        self.note(actor, "export audit", "", f"{len(rows)} rows")
        return as_csv(rows)

    def state(self, actor: Account) -> ChainState:
        """Follow the whole chain.

        Raises:
            Refused: The actor may not read the audit.
        """
        require(actor, "audit")
        return self._chain.whole()

    def look(self, actor: Account, shown: Iterable[AuditRow]) -> ChainState:
        """Whether the chain is whole: see ``AuditChain.look``.

        Args:
            actor: Who asks.
            shown: Rows that are shown beside the answer, newest first.

        Raises:
            Refused: The actor may not read the audit.
        """
        require(actor, "audit")
        return self._chain.look(shown)

    def start(self) -> None:
        """Start the thread that writes what was put off."""
        self._thread = threading.Thread(target=self._write_rows, name="audit", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Write what is still waiting and end the thread."""
        if self._thread is not None:
            self._later.put(None)
            self._thread.join()
            self._thread = None

    def _write_rows(self) -> None:
        going_on = True
        while going_on:
            rows, going_on = self._gathered()
            if rows:
                self._catalogue.record_audit_rows(rows)

    def _gathered(self) -> tuple[list[_Waiting], bool]:
        """What waits: views are gathered for a second, anything else is written at once with them."""
        rows: list[_Waiting] = []
        end_s = float("inf")
        while len(rows) < _MOST_AT_ONCE:
            wait_s = None if end_s == float("inf") else max(0.0, end_s - time.monotonic())
            try:
                row = self._later.get(timeout=wait_s)
            except queue.Empty:
                break
            if row is None:
                return rows, False
            rows.append(row)
            end_s = min(end_s, time.monotonic() + (_GATHER_S if row[1] == VIEW else 0.0))
        return rows, True


def as_csv(rows: Iterable[AuditRow]) -> str:
    """Rows as CSV with a header; no cell is read as a formula by a spreadsheet."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\r\n")
    table.writerow(("row", "utc", "person", "verb", "subject", "detail", "hash"))
    for row in rows:
        at = datetime.fromtimestamp(row.utc_ns // 1_000_000_000, tz=UTC).isoformat()
        cells = (row.actor, row.verb, row.subject, row.detail)
        table.writerow((row.seq, at, *(_plain(cell) for cell in cells), row.hash))
    return text.getvalue()


def _plain(cell: str) -> str:
    return f"'{cell}" if cell.startswith(_RISKY) else cell
