"""How hard damping may take hold: never harder than what it replaces, and never less than a little."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.safety.grip import AHEAD_SHARE, DRIVEN_SHARE, LEAST_SHARE, Grip, drives
from robot_iface.types import CommandMode, DeviceCommand, SafetyState

FULL_NMS_RAD = 0.15
ZEROS = np.zeros(3)


def law(q_rad: Any, stiffness: float = 0.9, damping: float = 0.035) -> DeviceCommand:
    return DeviceCommand(
        CommandMode.IMPEDANCE, ZEROS + q_rad, ZEROS, ZEROS, ZEROS + stiffness, ZEROS + damping, 1
    )


def reading(rigid: Any, **changes: Any) -> Any:
    changes = {name: ZEROS + value for name, value in changes.items()}
    return dataclasses.replace(rigid.RigidHand().read(), **changes)


def pushed(t_s: float) -> float:
    return 0.5


def begun(rigid: Any, command: DeviceCommand) -> Grip:
    grip = Grip(rigid.Rig().limits)
    grip.begin(command)
    return grip


@pytest.mark.parametrize("way", [-1.0, 1.0])
@pytest.mark.parametrize("speed", [0.0, 0.1, 1.0, 3.0, 20.0])
def test_its_torque_is_at_most_that_of_the_law_at_this_place_and_speed(
    rigid: Any, speed: float, way: float
) -> None:
    """Nothing is given yet and the load is at its highest: only what the law would give is allowed."""
    limit = rigid.Rig().limits.tau_interaction_nm
    state = reading(rigid, q_rad=0.8, dq_rad_s=way * speed, tau_interaction_nm=-0.3 * way)
    damping = begun(rigid, law(0.8 - 0.3 * way)).update(state)
    by_law = AHEAD_SHARE * (np.minimum(0.9 * 0.3, 0.9 * limit) + 0.035 * speed)
    assert np.all(damping * speed <= np.minimum(np.maximum(by_law, LEAST_SHARE * limit), 0.6) + 1e-12)
    assert np.all(damping <= FULL_NMS_RAD)
    if speed <= 0.1:
        assert np.all(damping == FULL_NMS_RAD)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_what_the_law_would_give_is_its_spring_and_its_damper_at_this_place_and_speed(
    rigid: Any, way: float
) -> None:
    """Nothing is given yet: what damping may reach is what the replaced command would give, to the digit."""
    rig = rigid.Rig()
    state = reading(rigid, q_rad=0.8, dq_rad_s=way * 5.0)
    for stiffness in (0.3, 10.0):
        spring_nm = np.minimum(stiffness * 0.4, 0.9 * rig.limits.tau_interaction_nm)
        command = law(0.8 - 0.4 * way, stiffness, 0.02)
        command = dataclasses.replace(command, dq_rad_s=ZEROS + way, tau_ff_nm=ZEROS - 0.03 * way)
        allowed = np.minimum(AHEAD_SHARE * (spring_nm + 0.02 * 4.0 + 0.03), rig.limits.tau_nm)
        assert begun(rigid, command).update(state) * 5.0 == pytest.approx(allowed)


def test_the_share_ahead_of_the_law_is_small() -> None:
    """More would load the hand more than the law does; less would let it become faster."""
    assert 1.0 <= AHEAD_SHARE <= 1.05


def test_a_law_that_pushes_with_the_motion_allows_the_least_only(rigid: Any) -> None:
    limit = rigid.Rig().limits.tau_interaction_nm
    state = reading(rigid, q_rad=0.8, dq_rad_s=3.0)
    damping = begun(rigid, law(2.0, damping=0.0)).update(state)
    assert damping * 3.0 == pytest.approx(LEAST_SHARE * limit)


def test_a_load_that_falls_is_made_up_for_and_one_that_rises_is_not(rigid: Any) -> None:
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    first = reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.4)
    assert grip.update(first) * 5.0 == pytest.approx(0.2)
    fallen = reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.3)
    assert grip.update(fallen) * 5.0 == pytest.approx(0.3)
    risen = reading(rigid, dq_rad_s=5.0, tau_nm=-0.3, tau_interaction_nm=-0.5)
    assert grip.update(risen) * 5.0 == pytest.approx(0.3)


def test_a_torque_beyond_what_was_allowed_does_not_raise_it(rigid: Any) -> None:
    """A device gives more than it was told where the hand grows faster in the tick: no reason for more."""
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    grip.update(reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.4))
    more = reading(rigid, dq_rad_s=5.0, tau_nm=-0.3, tau_interaction_nm=-0.4)
    assert grip.update(more) * 5.0 == pytest.approx(0.2)


def test_a_hand_that_grows_faster_is_damped_for_the_middle_of_the_tick(rigid: Any) -> None:
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    grip.update(reading(rigid, dq_rad_s=4.0, tau_nm=-0.2, tau_interaction_nm=-0.4))
    damping = grip.update(reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.4))
    assert damping * 5.5 == pytest.approx(0.2)


def test_a_hand_that_slows_down_is_damped_for_the_speed_that_it_has(rigid: Any) -> None:
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    grip.update(reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.4))
    damping = grip.update(reading(rigid, dq_rad_s=4.0, tau_nm=-0.2, tau_interaction_nm=-0.4))
    assert damping * 4.0 == pytest.approx(0.2)


def test_a_torque_along_the_motion_counts_as_none(rigid: Any) -> None:
    """What is made up for a fallen load is added to nothing, not taken from what does not brake."""
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    grip.update(reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.4))
    damping = grip.update(reading(rigid, dq_rad_s=5.0, tau_nm=0.1, tau_interaction_nm=-0.3))
    assert damping * 5.0 == pytest.approx(0.1)


def test_the_laws_damper_is_asked_for_the_same_middle(rigid: Any) -> None:
    grip = begun(rigid, law(0.8, 0.0, 0.04))
    grip.update(reading(rigid, dq_rad_s=4.0))
    damping = grip.update(reading(rigid, dq_rad_s=5.0))
    assert damping * 5.5 == pytest.approx(AHEAD_SHARE * 0.04 * 5.5)


def test_one_reading_is_answered_alike_and_what_is_begun_goes_on(rigid: Any) -> None:
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    state = reading(rigid, dq_rad_s=5.0, tau_nm=-0.2, tau_interaction_nm=-0.4)
    first = grip.update(state).copy()
    grip.begin(law(5.0, 100.0))
    assert np.array_equal(grip.update(state), first)
    assert grip.common_nms_rad == first.min()
    grip.drop()
    assert grip.common_nms_rad == FULL_NMS_RAD
    assert np.all(grip.update(state) == FULL_NMS_RAD), "without a load to follow the brake is whole"


def test_the_brake_is_that_of_the_fast_joints(rigid: Any) -> None:
    """A joint that hardly moves is braked fully for itself, and does not decide for the others."""
    grip = begun(rigid, law(0.8, 0.0, 0.0))
    damping = grip.update(reading(rigid, dq_rad_s=[5.0, 4.5, 2.0], tau_nm=[-0.3, -0.2, 0.0]))
    assert grip.common_nms_rad == damping[1]


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_who_drives_is_told_by_the_load_and_by_what_the_motor_gives(rigid: Any, way: float) -> None:
    limit = rigid.Rig().limits.tau_interaction_nm
    led = reading(rigid, dq_rad_s=way * 4.0, tau_interaction_nm=-way * limit, tau_nm=-0.3 * way * limit)
    assert drives(led, limit)
    unloaded = dataclasses.replace(led, tau_interaction_nm=0.0 * limit)
    assert not drives(unloaded, limit)
    at_the_bound = dataclasses.replace(led, tau_nm=-DRIVEN_SHARE * way * limit)
    assert not drives(at_the_bound, limit)
    runs_away = dataclasses.replace(led, tau_interaction_nm=way * limit)
    assert not drives(runs_away, limit)
    wrong_sign = dataclasses.replace(led, tau_nm=-0.8 * way * limit)
    assert not drives(wrong_sign, limit)


def test_a_stop_in_a_spasm_is_all_of_the_brake_and_a_speed_trip_is_not(rigid: Any) -> None:
    for stops in (False, True):
        rig = rigid.Rig(ramp_s=0.05, q_rad=0.8, rest_rad=0.8, stiffness=0.2)
        rig.go_active()
        rig.glide(np.deg2rad(30.0), 0.5)
        rig.hand.effort = pushed
        rig.ticks_until(SafetyState.COMPLIANT, 5)
        rig.button.down = stops
        rig.ticks_until(SafetyState.CAT1, 20)
        rig.cycle()
        assert rig.hand.mode == "brake"
        assert (rig.hand.brake_damping == FULL_NMS_RAD) is stops
