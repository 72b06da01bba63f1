"""A consistent copy of the data base while others write to it."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from sessions.catalogue.ledger import Ledger
from sessions.errors import Refused

_PAGES = 256


class Copying(Ledger):
    """Copies the data base."""

    def copy_to(self, target: Path) -> None:
        """Copy the data base as it is at one instant; writers are held up for milliseconds at a time.

        Args:
            target: New SQLite file; its folder exists.

        Raises:
            Refused: The catalogue is not SQLite.
        """
        if self._engine.dialect.name != "sqlite":
            raise Refused(
                "clinic data base",
                f"on {self._engine.dialect.name}",
                "an SQLite file, to be copied here",
                "back it up with the data base's own tools",
            )
        pooled = self._engine.raw_connection()
        try:
            source: Any = pooled.driver_connection
            with closing(sqlite3.connect(target)) as copy:
                source.backup(copy, pages=_PAGES)
        finally:
            pooled.close()
