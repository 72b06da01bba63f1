"""How the robot leads a hand back after a load: it pushes little, and holds nothing open."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from .reversing import CLOSING, gliding, load, unload, until_reversal


def test_what_leads_back_pushes_with_half_the_limit_at_most(rigid: Any) -> None:
    """A hand that is blocked on its way back: the spring of the reversal saturates."""
    rig = gliding(rigid, CLOSING, q_rad=0.3, rest_rad=0.3)
    rig.multiple = 10.0
    rig.run(5)
    load(rig, 1.2)
    until_reversal(rig)
    start = rig.states[-1].q_rad.copy()
    unload(rig)
    rig.hand.effort = lambda t_s: 30.0 * np.maximum(start - rig.hand.q, 0.0)
    rig.hand.corrupt = lambda state: dataclasses.replace(state, tau_interaction_nm=np.zeros(3))
    while rig.cycle().reversing:
        spring = rig.outcomes[-1].applied
        pull = spring.stiffness_nm_rad * (spring.q_rad - rig.states[-1].q_rad)
        assert np.all(np.abs(pull) <= 0.5 * rig.limits.tau_interaction_nm + 1e-9)
        assert np.all(np.abs(rig.outcomes[-1].applied_tau_nm) < 0.5 * 0.25 + 0.06)
    assert np.rad2deg(np.abs(rig.states[-1].q_rad - start)).max() < 3.0


def test_a_hand_that_goes_back_by_itself_is_only_damped(rigid: Any) -> None:
    """A flexor pull of 0.07 Nm carries the opening hand back faster than the reversal: no spring holds it."""
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    load(rig, -0.5)
    rig.hand.effort = lambda t_s: 0.07
    for _ in range(150):
        outcome = rig.cycle()
        assert outcome.reversing
        spring = outcome.applied.stiffness_nm_rad * (outcome.applied.q_rad - rig.states[-1].q_rad)
        assert np.all(spring >= 0.0), "a spring holds the hand open while it closes"
    assert np.rad2deg(rig.states[-1].dq_rad_s.min()) > 30.0
