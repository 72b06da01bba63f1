"""What every group of verbs stands on: the engine, the clock, and one short transaction per verb."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from sqlalchemy import Engine
from sqlalchemy.orm import Session

from sessions.catalogue.engine import WRITING


class Ledger:
    """Holds the engine.

    Args:
        engine: Engine whose data base has all tables.
        clock_ns: UTC in ns; tests give their own.
    """

    def __init__(self, engine: Engine, clock_ns: Callable[[], int] = time.time_ns) -> None:
        self._engine = engine
        self._for_writing = engine.execution_options(**WRITING)
        self._clock_ns = clock_ns

    @contextmanager
    def _reading(self) -> Generator[Session]:
        with Session(self._engine) as session:
            yield session

    @contextmanager
    def _writing(self) -> Generator[Session]:
        """One transaction: all of it or nothing."""
        with Session(self._for_writing) as session, session.begin():
            yield session
