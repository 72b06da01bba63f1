"""Hazard: a spasm, a tremor or clonus is taken for the patient's start, and the robot moves the hand."""

from __future__ import annotations

import pytest

from tests.bench.motion.trigger_map import Kind, false_starts

SEED = 5300


@pytest.mark.parametrize("kind", ["rest", "tremor", "clonus", "beats", "spasm", "one finger"])
def test_what_nobody_intended_is_no_start(kind: Kind) -> None:
    """Up to 0.05 Nm and 0.2 s; longer spasms are published in docs/trigger.md, not denied."""
    assert false_starts(kind, 60, SEED) == 0
