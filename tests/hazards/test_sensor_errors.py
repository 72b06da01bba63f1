"""Hazard 13: a zero or sign error after donning. The sensors disagree, or the loop runs away: it stops."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.types import SafetyState


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize("offset_deg", [15.0, -15.0])
def test_an_encoder_that_jumps_by_15_degrees(rigid: Any, joint: int, offset_deg: float) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()

    def jump(state: Any) -> Any:
        q = state.q_rad.copy()
        q[joint] += np.deg2rad(offset_deg)
        return dataclasses.replace(state, q_rad=q)

    rig.hand.corrupt = jump
    rig.cycle()
    assert rig.supervisor.state is SafetyState.CAT0
    assert rig.causes() == ["sensors-differ"]


def test_an_encoder_with_the_wrong_sign_stops_before_it_has_moved_six_degrees(rigid: Any) -> None:
    """The first movement after donning shows it: the two sensors part by twice the movement."""
    rig = rigid.Rig(ramp_s=0.05, stiffness=0.0)
    start = rig.hand.q.copy()

    def flip(state: Any) -> Any:
        return dataclasses.replace(state, q_rad=2 * start - state.q_rad, dq_rad_s=-state.dq_rad_s)

    rig.hand.corrupt = flip
    rig.go_active()
    rig.glide(0.3, 1.0)
    assert rig.supervisor.state is SafetyState.CAT0
    moved = np.rad2deg(np.abs(np.array([state.q_second_rad for state in rig.states]) - start))
    powered = [outcome.powered for outcome in rig.outcomes]
    assert moved[: int(np.sum(powered)) + 1].max() < 6.0


@pytest.mark.parametrize("multiple", [1.0, 3.0, 10.0])
@pytest.mark.parametrize("stiffness", [0.0, 0.04, 0.4])
def test_both_sensors_with_the_wrong_sign_trip_before_they_have_moved_five_degrees(
    rigid: Any, stiffness: float, multiple: float
) -> None:
    """A spring of the wrong sign is an unstable loop: it runs into the speed trip, and is braked there."""
    rig = rigid.Rig(multiple=multiple, ramp_s=0.05, stiffness=stiffness, device=rigid.FlippedHand)
    start = rig.hand.q.copy()
    rig.supervisor.start()
    rig.run(3)
    rig.supervisor.enable_edge()
    rig.run(100)
    moved: list[float] = []
    rig.speed = np.full(3, 0.17)
    for _ in range(2000):
        rig.cycle()
        moved.append(float(np.rad2deg(np.abs(rig.hand.q - start).max())))
    assert rig.causes() == ["speed-trip"]
    assert max(moved) < 5.0
