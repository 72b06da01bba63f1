"""A consistent copy of the data base while others write to it."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from sessions.catalogue.moving import Moving

_PAGES = 256


class Copying(Moving):
    """Copies the data base."""

    def copy_to(self, target: Path) -> None:
        """Copy the data base as it is at one instant; writers are held up for milliseconds at a time.

        Args:
            target: New SQLite file; its folder exists.

        Raises:
            Refused: A data base on a server does not answer.
            OSError: The target cannot be written: the disk is full, or refuses.
        """
        if self._engine.dialect.name != "sqlite":
            self.move_to(f"sqlite:///{target}")
            return
        pooled = self._engine.raw_connection()
        try:
            source: Any = pooled.driver_connection
            with closing(sqlite3.connect(target)) as copy:
                source.backup(copy, pages=_PAGES)
        except sqlite3.OperationalError as error:
            raise OSError(f"copy of the data base: {error}") from error
        finally:
            pooled.close()
