"""Hazard 22: the picture is late or nobody looks: a hand goes on moving beside what the screen shows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from robot_iface.safety import brake_and_close
from robot_iface.types import SafetyState

SILENT_NS = 1_000_000_000


def test_the_hand_is_held_within_a_second_and_a_tick_of_a_page_that_fell_silent(rigid: Any) -> None:
    rig = rigid.Rig(q_rad=0.9)
    rig.go_active()
    rig.speed = np.full(3, -0.2)
    for age_ms in range(1, 1001):
        rig.run(1, operator_age_ns=age_ms * 1_000_000)
    assert rig.supervisor.state is SafetyState.ACTIVE
    rig.run(1, operator_age_ns=SILENT_NS + 1)
    assert (rig.supervisor.state, rig.causes()) == (SafetyState.HOLD, ["operator-silent"])
    held = rig.hand.q.copy()
    rig.run(1000)
    assert np.abs(rig.hand.q - held).max() < np.deg2rad(2.0), "the hand moved on"


def test_a_page_that_comes_back_moves_nothing_by_itself(rigid: Any) -> None:
    rig = rigid.Rig(q_rad=0.9)
    rig.go_active()
    rig.run(1, operator_age_ns=SILENT_NS + 1)
    rig.run(500, operator_age_ns=0)
    assert rig.supervisor.state is SafetyState.HOLD


def test_a_stretch_that_nobody_looks_at_is_lowered(rigid: Any) -> None:
    rig = rigid.stretch()
    rig.run(1, operator_age_ns=SILENT_NS + 1)
    assert rig.outcomes[-1].load_share > 0.5
    rig.run(10_000)
    assert rig.outcomes[-1].load_share < 0.1, "the stretch is still held"


@pytest.mark.parametrize("age_ns", [0, SILENT_NS + 1])
def test_the_stop_needs_no_picture(rigid: Any, age_ns: int) -> None:
    rig = rigid.Rig(q_rad=0.9)
    rig.go_active()
    rig.run(1, operator_age_ns=age_ns)
    rig.button.down = True
    assert rig.ticks_until(SafetyState.CAT1, 1) == 1


def test_closing_without_anybody_brakes_first(rigid: Any) -> None:
    rig = rigid.stretch()
    rig.run(1, operator_age_ns=SILENT_NS + 1)
    before = len(rig.hand.log)

    def next_tick() -> int:
        rig.hand.step()
        return int(rig.hand.tick * rigid.PERIOD_NS)

    brake_and_close(rig.supervisor, next_tick)
    assert rig.hand.log[before:][:2] == ["brake", "power off"]
