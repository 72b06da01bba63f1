"""Hazard 6: hyperextension. Whatever take is given, no finger joint is moved below 0 degrees."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.control import FeedForward
from robot_iface.motion import QuinticPath, check_path
from robot_iface.safety import shipped_limits
from robot_iface.types import ReferencePath


@given(seed=st.integers(0, 10_000), lowest_deg=st.floats(-20.0, 10.0))
@settings(max_examples=60, deadline=None)
def test_the_check_passes_a_random_take_exactly_if_it_stays_above_zero(
    rigid: Any, seed: int, lowest_deg: float
) -> None:
    """Limits are asked for down to -30 degrees and still end at 0."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(40) * 1.0
    q = np.cumsum(np.cumsum(rng.normal(0.0, 0.02, (40, 3)), axis=0), axis=0)
    path = QuinticPath(ReferencePath(rigid.NAMES, t_s, q, "digest", "right"))
    dense = path.sample(np.linspace(0.0, 39.0, 39_001))
    shift = np.deg2rad(lowest_deg) - dense.min()
    moved = QuinticPath(ReferencePath(rigid.NAMES, t_s, q + shift, "digest", "right"))
    limits = shipped_limits(rigid.NAMES, np.full(3, -0.52), np.full(3, 60.0))
    found = check_path(moved, limits, 0.1, 0.01)
    angle = found is not None and found.quantity == "angle"
    if lowest_deg > 0.01:
        assert not angle
    elif lowest_deg < -0.01:
        assert found is not None
        assert not angle or found.bound == 0.0


def test_the_supervisor_holds_the_edge_at_zero_against_a_wrong_request(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05, q_rad=0.3, stiffness=0.0)
    rig.go_active()
    rig.glide(-0.5, 2.0)
    rig.run(300)
    lowest = np.rad2deg(np.min([state.q_rad for state in rig.states]))
    assert lowest > -0.5


def test_what_was_learnt_does_not_push_a_joint_through_zero(rigid: Any) -> None:
    """All of the extension torque that may be learnt, slewed as in a run: alone it would reach -15 deg."""
    rig = rigid.Rig(ramp_s=0.05, q_rad=0.2, rest_rad=0.2, stiffness=0.1, multiple=1.0)
    learner = FeedForward(1.0, rig.limits, 1.0)
    for place_s in np.linspace(0.0, 1.0, 101):
        learner.observe(float(place_s), np.full(3, -1.0), 0.2)
    learner.learn(np.ones(3), 0.5)
    assert np.allclose(learner.torque(0.5, rig.hand.q), -0.5 * rig.limits.tau_interaction_nm)
    rig.go_active()
    torque = np.zeros(3)

    def push(request: Any) -> Any:
        step = learner.torque(0.5, rig.hand.q) - torque
        torque[:] += np.clip(step, -0.15e-3, 0.15e-3)
        return replace(request, tau_ff_nm=torque.copy())

    rig.change = push
    rig.glide(-0.2, 1.0)
    rig.run(2000)
    assert np.rad2deg(np.min([state.q_rad for state in rig.states])) > -1.0
    assert rig.events() == []
