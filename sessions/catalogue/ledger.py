"""What every group of verbs stands on: the engine, the clock, and one short transaction per verb."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from sqlalchemy import Engine
from sqlalchemy.exc import DataError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from sqlalchemy.orm import Session

from sessions.catalogue.engine import WRITING, unusable
from sessions.catalogue.texts import unkeepable
from sessions.errors import NoAnswer


class _Joined(threading.local):
    """The transaction that verbs of this thread join, and the time of its rows."""

    def __init__(self) -> None:
        self.session: Session | None = None
        self.utc_ns = 0


class Ledger:
    """Holds the engine.

    Args:
        engine: Engine whose data base has all tables.
        clock_ns: UTC in ns; tests give their own.
    """

    def __init__(self, engine: Engine, clock_ns: Callable[[], int] = time.time_ns) -> None:
        self._engine = engine
        self._for_writing = engine.execution_options(**WRITING)
        self._clock = clock_ns
        self._mine = _Joined()

    def _clock_ns(self) -> int:
        """UTC in ns; within a delivery the time at which its rows were made."""
        return self._mine.utc_ns or self._clock()

    @contextmanager
    def _joined(self, session: Session, utc_ns: int) -> Generator[None]:
        """Every verb of this thread joins a transaction until the block ends."""
        self._mine.session, self._mine.utc_ns = session, utc_ns
        try:
            yield
        finally:
            self._mine.session, self._mine.utc_ns = None, 0

    @contextmanager
    def _reading(self) -> Generator[Session]:
        if self._mine.session is not None:
            yield self._mine.session
            return
        with self._answering(), Session(self._engine) as session:
            yield session

    @contextmanager
    def _writing(self) -> Generator[Session]:
        """One transaction: all of it or nothing."""
        if self._mine.session is not None:
            yield self._mine.session
            return
        with self._answering(), Session(self._for_writing) as session, session.begin():
            yield session

    @contextmanager
    def _answering(self) -> Generator[None]:
        """A data base that is gone, full or busy for too long is told in one sentence, as is a bad value.

        Raises:
            Refused: It does not answer, or cannot hold a value; nothing of the transaction was written.
        """
        try:
            yield
        except PoolTimeout as error:
            remedy = "try again in a moment"
            raise NoAnswer("clinic data base", "busy with other questions", "free", remedy) from error
        except (OperationalError, InterfaceError) as error:
            raise unusable(self._engine.dialect.name, error) from error
        except (DataError, UnicodeEncodeError) as error:
            raise unkeepable() from error
