"""What every group of verbs stands on: the engine, the clock, and one short transaction per verb."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from sqlalchemy import Engine
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session

from sessions.catalogue.engine import WRITING, unusable


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
        with self._answering(), Session(self._engine) as session:
            yield session

    @contextmanager
    def _writing(self) -> Generator[Session]:
        """One transaction: all of it or nothing."""
        with self._answering(), Session(self._for_writing) as session, session.begin():
            yield session

    @contextmanager
    def _answering(self) -> Generator[None]:
        """A data base that is gone, full or busy for too long is told in one sentence.

        Raises:
            Refused: It does not answer; nothing of the transaction was written.
        """
        try:
            yield
        except OperationalError as error:
            raise unusable(self._engine.dialect.name, error) from error
