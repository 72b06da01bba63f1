"""Hazard 4: the app dies while the hand is held at the end of its range."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot_iface.safety import brake_and_close
from robot_iface.types import SafetyState


def test_a_held_stretch_is_let_go_slowly_when_the_heartbeat_stops(rigid: Any) -> None:
    rig = rigid.Rig(multiple=6.0, q_rad=0.9, stiffness=0.4, rest_rad=0.9)
    rig.go_active()
    rig.glide(-0.2, 1.3)
    assert rig.outcomes[-1].load_share > 0.5
    for age_ms in range(1, 253):
        rig.run(1, heartbeat_age_ns=age_ms * 1_000_000)
    assert rig.supervisor.state is SafetyState.CAT1
    braked = len(rig.states)
    rig.run(5000)
    loads = np.array([outcome.load_share for outcome in rig.outcomes[braked:]])
    speeds = np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[braked:]]).max())
    assert loads[-1] < 0.05, "the stretch is still held"
    assert speeds < 150.0, "the hand snapped back"
    assert rig.outcomes[-1].powered is False


def test_a_held_stretch_is_let_go_slowly_when_the_loop_itself_breaks_off(rigid: Any) -> None:
    rig = rigid.Rig(multiple=6.0, ramp_s=0.05, q_rad=0.9, stiffness=0.4, rest_rad=0.9)
    rig.go_active()
    rig.glide(-0.2, 1.3)
    speeds = []

    def next_tick() -> int:
        rig.hand.step()
        speeds.append(float(np.rad2deg(np.abs(rig.hand.dq).max())))
        return int(rig.hand.tick * rigid.PERIOD_NS)

    brake_and_close(rig.supervisor, next_tick)
    assert rig.hand.log[-1] == "close"
    assert max(speeds) < 150.0, "the hand snapped back"
    assert speeds[-1] < 5.0
