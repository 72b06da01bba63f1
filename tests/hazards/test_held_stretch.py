"""Hazard 16: a stretch that the robot goes on holding at rest."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot_iface.types import SafetyState


def test_more_than_half_the_load_for_three_seconds_is_lowered_not_held(rigid: Any) -> None:
    rig = rigid.Rig(multiple=6.0, ramp_s=0.05, q_rad=0.9, stiffness=0.4, rest_rad=0.9)
    rig.go_active()
    rig.glide(-0.2, 1.3)
    held_at = len(rig.outcomes)
    rig.run(6500)
    loads = np.array([outcome.load_share for outcome in rig.outcomes[held_at:]])
    assert loads[0] > 0.5
    assert loads[4200:].max() < 0.5
    assert loads[-1] < 0.15
    assert (rig.causes(), rig.supervisor.state) == (["held-stretch"], SafetyState.HOLD)
    speeds = np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[held_at + 100 :]]).max())
    assert speeds <= 21.0
