"""Hazard 2: a contracture is taken for weakness. A virtual block must never raise assistance."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot_iface.control import AssistAsNeeded


def open_against(rigid: Any, assist: AssistAsNeeded, block_rad: float | None, weak: bool) -> None:
    """One repetition of opening by 40 degrees at 15 deg/s, against a block or with a weak hand."""
    hand = {"q_rad": 1.0, "rest_rad": 1.0, "stiffness": 0.35 if weak else 0.05}
    rig = rigid.Rig(ramp_s=0.05, **hand)
    rig.go_active()
    speed = np.full(3, np.deg2rad(-15.0))
    for _ in range(2600):
        if block_rad is not None:
            rig.hand.effort = lambda t_s: 30.0 * np.maximum(block_rad - rig.hand.q, 0.0)
        rig.speed, rig.multiple = speed, assist.multiple(speed)
        rig.cycle()
        state = rig.states[-1]
        assist.observe(speed, rig.goal - state.q_rad, state.dq_rad_s, state.tau_interaction_nm)
    assist.finish_repetition()


def test_a_blocked_opening_never_raises_assistance(rigid: Any) -> None:
    assist = AssistAsNeeded(rigid.NAMES, 1.5, rigid.PERIOD_S)
    for _ in range(3):
        before = assist.by_direction()
        open_against(rigid, assist, block_rad=0.85, weak=False)
        assert np.all(assist.by_direction() <= before + 1e-12)


def test_weakness_without_a_block_does_raise_it(rigid: Any) -> None:
    """The same error from a hand that lags but moves is weakness, and is helped."""
    assist = AssistAsNeeded(rigid.NAMES, 0.5, rigid.PERIOD_S)
    open_against(rigid, assist, block_rad=None, weak=True)
    assert assist.by_direction()[0].max() > 0.5
