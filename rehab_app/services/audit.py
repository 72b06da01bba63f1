"""Every verb leaves a row in the hash-chained audit; a stop's row is written behind it, never before."""

from __future__ import annotations

import threading
from queue import SimpleQueue

from rehab_app.access import Account
from sessions.catalogue import Catalogue


class Audit:
    """Writes audit rows.

    Args:
        catalogue: The clinic's catalogue.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._later: SimpleQueue[tuple[str, str, str, str] | None] = SimpleQueue()
        self._thread: threading.Thread | None = None

    def note(self, actor: Account, verb: str, subject: str = "", detail: str = "") -> None:
        """Write a row now."""
        self._catalogue.record_audit(actor.name, verb, subject, detail)

    def note_later(self, actor: str, verb: str, subject: str = "", detail: str = "") -> None:
        """Write a row from another thread; the caller waits for nothing."""
        self._later.put((actor, verb, subject, detail))

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
        while (row := self._later.get()) is not None:
            self._catalogue.record_audit(*row)
