from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.safety import MOTOR_CAP_NM, shipped_limits
from robot_iface.types import CommandMode, DeviceCommand, SafetyState

NAMES = ("thumb_cmc_abduction", "thumb_ip", "index_mcp_flexion", "index_pip", "index_dip")
LOW, HIGH = np.full(5, -0.2), np.full(5, 1.5)


def test_shipped_values() -> None:
    limits = shipped_limits(NAMES, LOW, HIGH)
    assert limits.tau_interaction_nm.tolist() == [0.25, 0.10, 0.25, 0.15, 0.08]
    assert limits.tau_nm.tolist() == [MOTOR_CAP_NM] * 5
    assert np.allclose(np.rad2deg(limits.extension_speed_rad_s), 30.0)
    assert np.allclose(np.rad2deg(limits.flexion_speed_rad_s), 60.0)
    assert np.rad2deg(limits.trip_speed_rad_s) == pytest.approx(200.0)


def test_spastic_hands_open_slowly_and_insensate_skin_carries_half() -> None:
    limits = shipped_limits(NAMES, LOW, HIGH, spastic=True, halved=True)
    assert np.allclose(np.rad2deg(limits.extension_speed_rad_s), 15.0)
    assert limits.tau_interaction_nm.tolist() == [0.125, 0.05, 0.125, 0.075, 0.04]


def test_no_hyperextension_by_default_but_the_thumb_base_has_negative_angles() -> None:
    assert shipped_limits(NAMES, LOW, HIGH).q_min_rad.tolist() == [-0.2, 0.0, 0.0, 0.0, 0.0]
    assert shipped_limits(NAMES, LOW, HIGH, hyperextension=True).q_min_rad.tolist() == [-0.2] * 5


def test_a_joint_without_a_range_is_refused_by_name() -> None:
    high = HIGH.copy()
    high[3] = -0.1
    with pytest.raises(Refused, match="range of index_pip"):
        shipped_limits(NAMES, LOW, high)


rows = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)
gains = st.lists(st.floats(0.0, 30.0), min_size=3, max_size=3).map(np.array)
requests = st.lists(
    st.builds(
        DeviceCommand,
        mode=st.sampled_from(CommandMode),
        q_rad=rows,
        dq_rad_s=rows,
        tau_ff_nm=rows,
        stiffness_nm_rad=gains,
        damping_nms_rad=gains.map(lambda gain: gain / 10),
        seq=st.just(0),
    ),
    min_size=1,
    max_size=40,
)


@given(sequence=requests, slow=st.floats(0.0, 1.0), factor=st.floats(0.01, 1.0))
@settings(max_examples=150, deadline=None)
def test_whatever_is_requested_the_torque_stays_within_the_limit(
    rigid: Any, sequence: list[DeviceCommand], slow: float, factor: float
) -> None:
    """Scaled so that many sequences stay below the trips and are clamped."""
    rig = rigid.Rig(ramp_s=0.02)
    rig.go_active()
    cap = 0.95 * rig.limits.tau_interaction_nm
    for request in sequence:
        change = {
            "q_rad": rig.hand.q + 0.1 * slow * request.q_rad,
            "dq_rad_s": slow * request.dq_rad_s,
            "tau_ff_nm": 0.02 * request.tau_ff_nm,
            "stiffness_nm_rad": factor * request.stiffness_nm_rad,
            "damping_nms_rad": factor * request.damping_nms_rad,
        }
        rig.change = lambda _, change=change, request=request: dataclasses.replace(request, **change)
        before, speed = rig.hand.q.copy(), rig.hand.dq.copy()
        outcome = rig.cycle()
        if outcome.safety_state is not SafetyState.ACTIVE:
            return
        sent = rig.hand.command
        torque = sent.tau_ff_nm.copy()
        if sent.mode is CommandMode.IMPEDANCE:
            torque += sent.stiffness_nm_rad * (sent.q_rad - before)
            torque += sent.damping_nms_rad * (sent.dq_rad_s - speed)
        assert np.all(np.abs(torque) <= cap + 1e-9)
        assert np.allclose(torque, outcome.applied_tau_nm, atol=1e-9)


def test_a_request_within_all_limits_passes_untouched(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.02)
    rig.go_active()
    outcome = rig.glide(0.2, 0.2)
    assert outcome.safety_state is SafetyState.ACTIVE
    assert np.array_equal(outcome.applied_tau_nm, outcome.requested_tau_nm)
    assert rig.hand.command is outcome.applied


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_goal_outside_the_range_is_pulled_to_its_edge(rigid: Any, sign: float) -> None:
    """No request, however patient, moves a joint out of today's range."""
    rig = rigid.Rig(ramp_s=0.02, stiffness=0.0)
    rig.go_active()
    rig.glide(sign * 0.5, 4.0)
    rig.run(500)
    edge = rig.limits.q_max_rad if sign > 0 else rig.limits.q_min_rad
    assert np.abs(rig.states[-1].q_rad - edge).max() < np.deg2rad(0.5)
    assert rig.events() == []


def test_a_stiff_hand_saturates_instead_of_stopping_the_run(rigid: Any) -> None:
    """Shipped limits, a joint of 0.52 Nm/rad (MAS 2): it opens as far as the limit carries it."""
    rig = rigid.Rig(multiple=10.0, ramp_s=0.05, q_rad=1.2, stiffness=0.52, rest_rad=1.2)
    rig.go_active()
    rig.glide(np.deg2rad(-15.0), 4.0)
    assert rig.events() == []
    opened = np.rad2deg(1.2 - rig.states[-1].q_rad)
    assert np.allclose(opened, np.rad2deg(0.9 * rig.limits.tau_interaction_nm / 0.52), atol=1.5)
    assert 22.0 < opened[0] < 27.0, "the figure of the reference for 0.25 Nm"
    assert 0.85 < rig.outcomes[-1].load_share < 1.0
