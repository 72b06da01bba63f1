"""Services that are built when they are first used: a command pays for nothing else."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Generic, TypeVar, cast

T = TypeVar("T")
_BUILDING = threading.RLock()  # one for all: services that share a third one build it once


def later(build: Callable[[], T]) -> T:
    """What stands for a service until it is used; from then on it is that service.

    Args:
        build: Makes the service, with its imports; called once, at the first use, from whatever thread.
    """
    return cast("T", _Later(build))


class _Later(Generic[T]):
    """Passes everything on to what it builds."""

    __slots__ = ("_build", "_built")
    _build: Callable[[], T]
    _built: tuple[T, ...]

    def __init__(self, build: Callable[[], T]) -> None:
        object.__setattr__(self, "_build", build)
        object.__setattr__(self, "_built", ())

    def _there(self) -> T:
        """What is built; it is built now where it was not."""
        built: tuple[T, ...] = self._built
        if built:
            return built[0]
        with _BUILDING:
            built = self._built or (self._build(),)
            object.__setattr__(self, "_built", built)
        return built[0]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._there(), name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._there(), name, value)

    def __delattr__(self, name: str) -> None:
        delattr(self._there(), name)
