"""How far a long piece of work has come."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Told how far it has come."""

    def __call__(self, done: int, total: int | None) -> None:
        """Take the number of frames done, and of all where it is known."""
        ...


def untold(done: int, total: int | None) -> None:
    """Nobody wants to know."""
