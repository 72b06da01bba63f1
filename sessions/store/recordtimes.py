"""When a record is filed: its own times, checked against its topic."""

from __future__ import annotations

from typing import Any

import numpy as np

from sessions.errors import Refused
from sessions.records import Topic
from sessions.records.fields import Int64

BLOCK_SPAN_MAX_NS = 10_000_000_000
"""Longest block; a reader looks no further back than this for a block that reaches into its range."""


def times_of(topic: Topic, record: Any) -> tuple[int, int]:
    """First and last time of a record, monotonic in ns; equal but for blocks.

    Raises:
        Refused: The record is of another type than its topic, or its times are not rising whole numbers.
    """
    if type(record) is not topic.record:
        raise Refused(
            f"record on {topic.name}", type(record).__name__, topic.record.__name__, "choose its own topic"
        )
    if not isinstance(record.t_ns, np.ndarray):
        if not isinstance(record.t_ns, int | np.integer):
            raise Refused(f"t_ns on {topic.name}", repr(record.t_ns)[:40], "whole nanoseconds", "stamp it so")
        return int(record.t_ns), int(record.t_ns)
    ticks: Int64 = record.t_ns
    if ticks.ndim != 1 or ticks.size == 0 or bool((ticks[1:] < ticks[:-1]).any()):
        raise Refused(f"t_ns on {topic.name}", "empty or falling", "rising", "stamp every tick by one clock")
    first_ns, last_ns = int(ticks[0]), int(ticks[-1])
    if last_ns - first_ns > BLOCK_SPAN_MAX_NS:
        raise Refused(
            f"block on {topic.name}",
            f"{last_ns - first_ns} ns long",
            f"at most {BLOCK_SPAN_MAX_NS} ns",
            "split it",
        )
    return first_ns, last_ns
