"""The audit that also counts: how often each verb was done, and what caused the stops."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Mapping

from rehab_app.access import Account
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue

STOP = "stop"
PERSON = "a person"
_SUPERVISOR = "the safety supervisor"
ENDING = "the end of the server"


class CountedAudit(Audit):
    """An audit whose rows are counted as they pass; no name and no subject is kept.

    Args:
        catalogue: The clinic's catalogue.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        super().__init__(catalogue)
        self._counting = threading.Lock()
        self._verbs: Counter[str] = Counter()
        self._stops: Counter[str] = Counter()

    def note(self, actor: Account, verb: str, subject: str = "", detail: str = "") -> None:
        """Write a row now."""
        super().note(actor, verb, subject, detail)
        with self._counting:
            self._verbs[verb] += 1

    def note_later(self, actor: str, verb: str, subject: str = "", detail: str = "") -> None:
        """Write a row from another thread; the caller waits for nothing."""
        super().note_later(actor, verb, subject, detail)
        with self._counting:  # held for a count only, never while something is written
            self._verbs[verb] += 1
            if verb == STOP:
                self._stops[cause_of(actor)] += 1

    def verbs(self) -> Mapping[str, int]:
        """How often each verb was done."""
        with self._counting:
            return dict(self._verbs)

    def stops(self) -> Mapping[str, int]:
        """How often each cause stopped; whoever pressed is "a person"."""
        with self._counting:
            return dict(self._stops)


def cause_of(source: str) -> str:
    """The cause of a stop without anybody's name.

    Args:
        source: Who or what stopped, as it stands in the audit.
    """
    known = source in (_SUPERVISOR, ENDING) or source.startswith(f"{_SUPERVISOR}: ")
    return source if known else PERSON
