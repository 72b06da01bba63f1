"""Whether the audit's chain is whole: followed whole once, then what was added since, and again each day."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise

from rehab_app.errors import NoAnswer, Refused
from sessions.catalogue import AuditRow, Catalogue
from sessions.catalogue.audit import START, broken, is_itself

WHOLE_NS = 86_400 * 1_000_000_000
"""After a day a look follows the whole chain again, whoever looks."""


@dataclass(frozen=True, slots=True)
class ChainState:
    """What following the chain gave.

    Attributes:
        rows: Rows that follow from each other.
        head: Hash of the newest; kept elsewhere, it shows later that no row was cut off the end.
        problem: Where the chain breaks, "" where it does not.
        whole_utc_ns: When all of it was followed last, UTC ns.
        since: How many rows were added and followed since.
    """

    rows: int
    head: str
    problem: str
    whole_utc_ns: int = 0
    since: int = 0


class AuditChain:
    """Follows the chain; remembers in this process how far it did. Thread-safe.

    What is remembered can only find more: a chain that was written anew follows from itself, but its rows are
    no longer those that were followed before.

    Args:
        catalogue: The clinic's catalogue.
        clock_ns: UTC in ns.
    """

    def __init__(self, catalogue: Catalogue, clock_ns: Callable[[], int] = time.time_ns) -> None:
        self._catalogue = catalogue
        self._clock_ns = clock_ns
        self._following = threading.Lock()
        self._end = START
        self._whole = START
        self._whole_utc_ns = 0

    def whole(self) -> ChainState:
        """Follow the whole chain; some seconds for some hundred thousand rows.

        Raises:
            Refused: The data base does not answer.
        """
        with self._following:
            return self._told(self._follow_whole)

    def look(self, shown: Iterable[AuditRow]) -> ChainState:
        """Follow what was added since, and check the rows that are shown; follow all where that is a day ago.

        Args:
            shown: Rows that somebody is about to read, newest first.

        Raises:
            Refused: The data base does not answer.
        """
        with self._following:
            age_ns = self._clock_ns() - self._whole_utc_ns
            if not self._whole_utc_ns or not 0 <= age_ns < WHOLE_NS:
                return self._told(self._follow_whole)
            state = self._told(lambda: self._follow_added(shown))
            if not state.problem:
                return state
            first = self._told(self._follow_whole)  # names the first row that is wrong
            return first if first.problem else state

    def _told(self, follow: Callable[[], None]) -> ChainState:
        try:
            follow()
        except NoAnswer:
            raise
        except Refused as refusal:
            return ChainState(0, "", str(refusal), self._whole_utc_ns)
        since = self._end.rows - self._whole.rows
        return ChainState(self._end.rows, self._end.head, "", self._whole_utc_ns, since)

    def _follow_whole(self) -> None:
        begun_ns, end = self._clock_ns(), self._catalogue.follow_audit()
        if self._end.rows:
            self._catalogue.follow_audit(self._end)
        self._end, self._whole, self._whole_utc_ns = end, end, begun_ns

    def _follow_added(self, shown: Iterable[AuditRow]) -> None:
        end = self._catalogue.follow_audit(self._end)
        check_shown(shown)
        self._end = end


def check_shown(rows: Iterable[AuditRow]) -> None:
    """Refuse rows that are not what was written, as far as they tell by themselves and by their neighbours.

    Args:
        rows: Rows, newest first; some may be left out.

    Raises:
        Refused: One is another than was written.
    """
    held = tuple(rows)
    for row in held:
        if not is_itself(row):
            raise broken(row.seq, row.seq)
    for newer, older in pairwise(held):
        if newer.seq == older.seq + 1 and newer.previous_hash != older.hash:
            raise broken(newer.seq, newer.seq)
