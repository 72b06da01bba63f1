"""The name of the clinic at the head of a report that people read; formats for programs do not carry it."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar

from sessions.reports.language import _

_clinic: ContextVar[str] = ContextVar("name of the clinic", default="")


@contextmanager
def headed(clinic: str) -> Generator[None]:
    """Every report that is printed inside names this clinic, "" for none."""
    before = _clinic.set(clinic)
    try:
        yield
    finally:
        _clinic.reset(before)


def letterhead() -> tuple[tuple[str, str], ...]:
    """The row of facts that names the clinic; nothing where no name was given."""
    clinic = _clinic.get()
    return ((_("Clinic"), clinic),) if clinic else ()
