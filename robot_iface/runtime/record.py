"""Collects what a run says: blocks of ticks, phases, events, and the digest over all of them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np

from robot_iface.runtime.kernels import write_row
from robot_iface.runtime.seal import canonical_bytes
from robot_iface.types import Float64, PhaseChange, RunEnd, SafetyEvent, TickBlock

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
        self._t_ns = np.empty(BLOCK_TICKS, dtype=np.int64)
        self._path = np.empty((2, BLOCK_TICKS))
        self._safety = np.empty(BLOCK_TICKS, dtype=np.uint8)
        self._joints = joints
        self._block = np.empty((BLOCK_TICKS, len(_ROW_COLUMNS) * joints))
        self._count = 0
        still = np.zeros(joints)
        write_row(self._block, 0, *(still,) * len(_ROW_COLUMNS))  # compiles it

    def tick(
        self, t_ns: int, path_s: float, path_speed: float, safety_state: int, rows: tuple[Float64, ...]
    ) -> None:
        """Add one tick; ``rows`` holds the (J,) columns of TickBlock in their order."""
        count = self._count
        self._t_ns[count] = t_ns
        self._path[0, count] = path_s
        self._path[1, count] = path_speed
        self._safety[count] = safety_state
        write_row(self._block, count, *rows)
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
        columns = np.split(self._block[:count].copy(), len(_ROW_COLUMNS), axis=1)
        self._send(
            TickBlock(
                t_ns=self._t_ns[:count].copy(),
                path_s=self._path[0, :count].copy(),
                path_speed=self._path[1, :count].copy(),
                safety_state=self._safety[:count].copy(),
                **dict(zip(_ROW_COLUMNS, columns, strict=True)),
            )
        )
        self._count = 0

    def _send(self, message: Message) -> None:
        self._digest.update(canonical_bytes(message))
        self._sink(message)
