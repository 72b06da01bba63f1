"""Collects what a run says: blocks of ticks, phases, events, and the digest over all of them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np

from robot_iface.runtime.seal import canonical_bytes
from robot_iface.types import PhaseChange, RunEnd, SafetyEvent, TickBlock

BLOCK_TICKS = 50
Message: TypeAlias = PhaseChange | SafetyEvent | TickBlock
Sink: TypeAlias = Callable[[Message | RunEnd], None]

_SCALARS: dict[str, Any] = {
    "t_ns": np.int64,
    "path_s": np.float64,
    "path_speed": np.float64,
    "safety_state": np.uint8,
}
COLUMNS: tuple[str, ...] = tuple(entry.name for entry in fields(TickBlock))
_ROW_COLUMNS: tuple[str, ...] = tuple(name for name in COLUMNS if name not in _SCALARS)


class Recorder:
    """Passes a run's messages to a sink, in order, and digests them.

    Args:
        sink: Receives every message.
        joints: Number of driven joints J.
    """

    def __init__(self, sink: Sink, joints: int) -> None:
        self._sink = sink
        self._digest = hashlib.sha256()
        self._scalars: list[tuple[int, float, float, int]] = []
        self._rows = np.empty((len(_ROW_COLUMNS), BLOCK_TICKS, joints))
        self._count = 0

    def tick(
        self, t_ns: int, path_s: float, path_speed: float, safety_state: int, rows: tuple[Any, ...]
    ) -> None:
        """Add one tick; ``rows`` holds the (J,) columns of TickBlock in their order."""
        self._scalars.append((t_ns, path_s, path_speed, safety_state))
        block, count = self._rows, self._count
        for column, row in enumerate(rows):
            block[column, count] = row
        self._count = count + 1
        if self._count == BLOCK_TICKS:
            self._flush()

    def say(self, message: PhaseChange | SafetyEvent) -> None:
        """Add a phase or an event."""
        self._send(message)

    def end(self) -> str:
        """Send what is left and return the digest, SHA-256 in hexadecimal."""
        self._flush()
        return self._digest.hexdigest()

    def _flush(self) -> None:
        count = self._count
        if not count:
            return
        values: dict[str, Any] = {
            name: np.array(column, dtype=kind)
            for (name, kind), column in zip(_SCALARS.items(), zip(*self._scalars, strict=True), strict=True)
        }
        values |= {name: self._rows[index, :count].copy() for index, name in enumerate(_ROW_COLUMNS)}
        self._scalars.clear()
        self._count = 0
        self._send(TickBlock(**values))

    def _send(self, message: Message) -> None:
        self._digest.update(canonical_bytes(message))
        self._sink(message)
