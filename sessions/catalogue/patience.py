"""How long a server is waited for: a network that is cut, or a server that stands still, says nothing."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import psycopg
from psycopg.waiting import Ready
from sqlalchemy import Engine, event

CONNECT_S = 2
PING_S = 2.0
"""A connection that lay idle is asked first whether it still holds; with a new one that makes 4 s."""
SILENCE_S = 4.0
"""Whoever waits for a page is told after this long without one byte from the server."""
LOCK_MS = 3_500
STATEMENT_MS = 30_000
_MIGRATING_S = 35.0


class PatientConnection(psycopg.Connection[Any]):
    """A connection that gives up on a server which says nothing.

    Attributes:
        silence_s: How long the server may be silent.
    """

    silence_s = PING_S

    def wait(self, gen: Any, *given: Any, **named: Any) -> Any:
        """Wait for an answer, no longer than the server may be silent.

        Raises:
            psycopg.OperationalError: It was silent for longer; the connection is closed.
        """
        try:
            return super().wait(_bounded(gen, self.silence_s, time.monotonic), *given, **named)
        except _Silent:
            self.pgconn.finish()
            said = f"the server says nothing for {self.silence_s:g} s"
            raise psycopg.OperationalError(said) from None


def asked_of_server() -> dict[str, Any]:
    """What the driver is told of each new connection."""
    return {
        "connect_timeout": CONNECT_S,
        "options": f"-c statement_timeout={STATEMENT_MS} -c lock_timeout={LOCK_MS}",
    }


def be_patient(engine: Engine) -> None:
    """Make an engine of PostgreSQL wait as this module says."""
    event.listen(engine, "do_connect", _connect)
    event.listen(engine, "checkin", _ping_next)


def wait_as_asked(driver: Any, migrating: bool) -> None:
    """How long a transaction that begins now waits; one that migrates waits for other stations' migrations.

    Args:
        driver: The driver's own connection.
        migrating: Whether it migrates.
    """
    driver.silence_s = _MIGRATING_S if migrating else SILENCE_S
    if migrating:
        driver.execute(f"SET LOCAL lock_timeout = {STATEMENT_MS}")


class _Silent(Exception):
    """The server said nothing for too long."""


def _connect(_dialect: object, _record: object, given: Any, named: Any) -> PatientConnection:
    return PatientConnection.connect(*given, **named)


def _ping_next(driver: Any, _record: object) -> None:
    if driver is not None:
        driver.silence_s = PING_S


def _bounded(gen: Any, silence_s: float, clock_s: Callable[[], float]) -> Any:
    """The driver's own steps; between two of them it says every tenth of a second that nothing came."""
    try:
        step = next(gen)
        heard_s = clock_s()
        while True:
            ready = yield step
            if ready != Ready.NONE:
                heard_s = clock_s()
            elif clock_s() - heard_s > silence_s:
                raise _Silent
            step = gen.send(ready)
    except StopIteration as end:
        return end.value
