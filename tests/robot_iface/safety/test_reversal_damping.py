"""How strongly the hand is damped while a load is gone back on, and when that has failed."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.types import SafetyState

OPENING = np.deg2rad(-15.0)
FULL_NMS_RAD = 0.15


def report(rig: Any, share: float) -> None:
    """From now on the device reports this load at every joint, as a share of its limit."""
    rig.hand.corrupt = lambda state: dataclasses.replace(
        state, tau_interaction_nm=share * rig.limits.tau_interaction_nm
    )


def reversing(rigid: Any) -> Any:
    """An opening hand whose load is gone back on."""
    rig = rigid.Rig(ramp_s=0.05, q_rad=0.8, rest_rad=0.8, stiffness=0.0)
    rig.go_active()
    rig.glide(OPENING, 0.5)
    rig.speed = np.full(3, OPENING)
    report(rig, -1.2)
    rig.run(10)
    assert rig.outcomes[-1].reversing
    return rig


@pytest.mark.parametrize("joint", range(3))
def test_a_hand_that_is_thrown_is_damped_with_the_highest_load_that_it_had(rigid: Any, joint: int) -> None:
    """The device makes up for what the load has fallen by, and for no more: a brake must not be a blow."""
    rig = reversing(rigid)
    report(rig, -0.5)
    rig.run(20)
    rig.hand.dq[joint] = np.deg2rad(150.0)
    given = float(np.abs(rig.hand.tau[joint]))
    outcome = rig.cycle()
    assert outcome.reversing
    limit = rig.limits.tau_interaction_nm[joint]
    braking = -float(outcome.applied_tau_nm[joint])
    assert 0.25 * limit <= braking
    assert braking <= max(given + (1.2 - 0.5) * limit, FULL_NMS_RAD * np.deg2rad(150.0)) + 1e-9
    assert braking < FULL_NMS_RAD * (np.deg2rad(150.0) - np.deg2rad(15.0))
    rig.hand.dq[joint] = np.deg2rad(-199.0)
    assert np.abs(rig.cycle().applied_tau_nm[joint]) <= 0.6


def test_where_it_fails_nothing_of_the_damping_is_taken_back(rigid: Any) -> None:
    """It was there already: a hand that has been damped fully is not let go to begin anew."""
    rig = reversing(rigid)
    report(rig, -0.9)
    rig.ticks_until(SafetyState.COMPLIANT, 201)
    assert np.all(rig.outcomes[-1].applied.damping_nms_rad == FULL_NMS_RAD)
    rig.run(5)
    assert np.all(rig.outcomes[-1].applied.damping_nms_rad == FULL_NMS_RAD)


def test_a_hand_that_rests_is_damped_fully_at_once(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    report(rig, -1.6)
    rig.run(12)
    assert all(np.all(outcome.applied.damping_nms_rad == FULL_NMS_RAD) for outcome in rig.outcomes[-12:])


@pytest.mark.parametrize("speed_deg_s", [-15.0, 30.0])
def test_a_hand_that_is_blocked_on_its_way_back_is_pulled_with_half_the_limit(
    rigid: Any, speed_deg_s: float
) -> None:
    """The spring that leads back fills as far as it may, and towards the way back, whichever that is."""
    rig = rigid.Rig(ramp_s=0.05, q_rad=0.8, rest_rad=0.8, stiffness=0.0)
    rig.go_active()
    rig.glide(np.deg2rad(speed_deg_s), 0.3)
    rig.speed = np.full(3, np.deg2rad(speed_deg_s))
    report(rig, 1.2 * np.sign(speed_deg_s))
    rig.run(10)
    assert rig.outcomes[-1].reversing
    place = rig.states[-1].q_rad.copy()
    report(rig, 0.0)
    rig.hand.effort = lambda t_s: 30.0 * (place - rig.hand.q) - 0.1 * rig.hand.dq
    pulls = []
    while rig.cycle().reversing:
        led = rig.outcomes[-1].applied
        pulls.append(led.stiffness_nm_rad * (led.q_rad - rig.states[-1].q_rad))
    way = -np.sign(speed_deg_s)
    assert np.all(np.array(pulls[20:]) * way > 0.0)
    assert pulls[-1] == pytest.approx(way * 0.5 * rig.limits.tau_interaction_nm, rel=0.02)


def test_a_new_enable_gives_all_torque_at_the_end_of_its_ramp_also_after_a_reversal(rigid: Any) -> None:
    rig = reversing(rigid)
    report(rig, 0.0)
    while rig.outcomes[-1].reversing:
        rig.cycle()
    rig.speed = np.zeros(3)
    rig.supervisor.finish()
    rig.run(300)
    rig.supervisor.enable_edge()
    rig.goal = rig.hand.q.copy()
    rig.ticks_until(SafetyState.ACTIVE, 60)
    wanted = 0.9 * rig.limits.tau_interaction_nm
    rise = [0.0]

    def push(request: Any) -> Any:
        rise[0] = min(rise[0] + 0.25, 1.0)
        zeros = np.zeros(3)
        return dataclasses.replace(
            request, tau_ff_nm=rise[0] * wanted, stiffness_nm_rad=zeros, damping_nms_rad=zeros
        )

    rig.change = push
    rig.run(4)
    assert rig.outcomes[-1].applied_tau_nm == pytest.approx(wanted)


def test_only_joints_over_their_limit_say_whether_the_patient_opposes(rigid: Any) -> None:
    """A neighbour that is carried along lightly does not keep the loaded joint from being gone back on."""
    rig = rigid.Rig(ramp_s=0.05, q_rad=0.8, rest_rad=0.8, stiffness=0.0)
    rig.go_active()
    rig.glide(OPENING, 0.3)
    rig.speed = np.full(3, OPENING)
    rig.hand.corrupt = lambda state: dataclasses.replace(
        state, tau_interaction_nm=np.array([-1.2, 0.4, 0.4]) * rig.limits.tau_interaction_nm
    )
    rig.run(10)
    assert rig.causes() == ["reversal"]
