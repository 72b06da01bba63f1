"""Edges of single rules, to the tick and to the last bit: what mutation of the code found untested."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.safety import THERAPIST_CAP_NM, admit_limits, pack_hulls, shipped_limits
from robot_iface.safety.settling import Settling
from robot_iface.safety.yielding import Holding, damped
from robot_iface.types import Hull, SafetyState

NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
LIMITS = shipped_limits(NAMES, np.zeros(3), np.full(3, 1.6))
PERIOD_S = 1e-3


def ticks_to_rest(rigid: Any, quiet_share: float, speed_deg_s: float, loaded_share: float = 0.0) -> int:
    """Braked ticks until power may be cut, of a hand whose load has just fallen to a share."""
    settling = Settling(PERIOD_S)
    settling.note(loaded_share)
    settling.begin()
    hand = rigid.RigidHand()
    hand.dq[1] = np.deg2rad(speed_deg_s)
    state = hand.read()
    for tick in range(1, 6000):
        settling.note(quiet_share)
        if settling.over(state):
            return tick
    raise AssertionError("never")


@pytest.mark.parametrize(
    ("quiet_share", "speed_deg_s", "loaded_share", "ticks"),
    [
        (0.0, 4.99, 0.0, 100),
        (0.0, -4.99, 0.5, 100),
        (0.5, 0.0, 0.51, 3000),
        (0.51, 0.0, 0.0, 5000),
        (0.0, 5.01, 0.0, 5000),
        (0.0, -5.01, 0.0, 5000),
    ],
)
def test_a_braked_hand_rests_after_so_long(
    rigid: Any, quiet_share: float, speed_deg_s: float, loaded_share: float, ticks: int
) -> None:
    assert ticks_to_rest(rigid, quiet_share, speed_deg_s, loaded_share) == pytest.approx(ticks, abs=1)


def test_a_brake_begins_anew_with_every_brake(rigid: Any) -> None:
    settling = Settling(PERIOD_S)
    state = rigid.RigidHand().read()
    for _ in range(90):
        assert not settling.over(state)
    settling.begin()
    assert [settling.over(state) for _ in range(101)].index(True) in (99, 100)
    fast = dataclasses.replace(state, dq_rad_s=np.full(3, 1.0))
    settling.begin()
    for _ in range(4000):
        assert not settling.over(fast)
    settling.begin()
    assert not any(settling.over(fast) for _ in range(4990))


def test_a_hull_that_only_touches_the_range_is_refused() -> None:
    square = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])
    limits = dataclasses.replace(
        shipped_limits(NAMES, np.array([0.5, 0.0, 0.0]), np.full(3, 1.6)), hulls=(Hull(NAMES[:2], square),)
    )
    with pytest.raises(Refused, match="outside today's range"):
        pack_hulls(limits, NAMES)


@pytest.mark.parametrize(("sign", "end"), [(-1.0, 0.4), (1.0, 0.8)])
def test_a_hull_s_event_names_the_end_that_was_passed(rigid: Any, sign: float, end: float) -> None:
    """The bound lies outside the nearest point by the margin, on the side where the joint is."""
    square = np.array([[0.4, 0.4], [0.8, 0.4], [0.8, 0.8], [0.4, 0.8]])
    rig = rigid.Rig(ramp_s=0.05, limits=dataclasses.replace(LIMITS, hulls=(Hull(NAMES[:2], square),)))
    rig.go_active()
    rig.hand.q[1] = end + sign * np.deg2rad(2.1)
    rig.supervisor._previous, rig.supervisor._continued = None, False
    assert rig.cycle().safety_state is SafetyState.CAT1
    event = rig.events()[0]
    assert (event.cause, event.joint) == ("hull", NAMES[1])
    assert event.value == pytest.approx(end + sign * np.deg2rad(2.1))
    assert event.bound == pytest.approx(end + sign * np.deg2rad(2.0))


@pytest.mark.parametrize("joint", range(3))
def test_a_therapist_s_limit_itself_is_admitted_and_anything_above_or_not_above_zero_is_not(
    rigid: Any, joint: int
) -> None:
    capabilities = rigid.RigidHand().capabilities
    for torque, admitted in (
        (THERAPIST_CAP_NM, True),
        (THERAPIST_CAP_NM + 1e-6, False),
        (1e-6, True),
        (0.0, False),
        (-0.1, False),
        (float("nan"), False),
    ):
        torques = LIMITS.tau_interaction_nm.copy()
        torques[joint] = torque
        limits = dataclasses.replace(LIMITS, tau_interaction_nm=torques)
        if admitted:
            admit_limits(limits, capabilities, 0.0, 0)
        else:
            with pytest.raises(Refused, match=f"interaction torque of {NAMES[joint]}"):
                admit_limits(limits, capabilities, 0.0, 0)


@pytest.mark.parametrize(
    ("field", "good", "bad", "message"),
    [
        ("trip_speed_rad_s", np.deg2rad([200.0, 0.1]), np.deg2rad([200.1, 0.0, -1.0]), "trip speed"),
        ("margin_rad", np.deg2rad([0.0, 2.0]), np.deg2rad([-0.1, 2.1]), "margin of the range"),
    ],
)
def test_what_trips_may_be_narrowed_and_never_widened(
    rigid: Any, field: str, good: Any, bad: Any, message: str
) -> None:
    capabilities = rigid.RigidHand().capabilities
    for value in good.tolist():
        admit_limits(dataclasses.replace(LIMITS, **{field: value}), capabilities, 0.0, 0)
    for value in bad.tolist():
        with pytest.raises(Refused, match=message):
            admit_limits(dataclasses.replace(LIMITS, **{field: value}), capabilities, 0.0, 0)


def test_a_held_posture_gives_way_only_where_it_is_loaded(rigid: Any) -> None:
    """Below a tenth of its limit a joint stays; above, it yields by at most 20 deg/s, all of it from 30 %."""
    hand = rigid.RigidHand()
    held = damped(np.full(3, 0.05), 7)
    held = dataclasses.replace(held, q_rad=hand.q.copy(), tau_ff_nm=np.full(3, 0.02))
    holding = Holding(held, LIMITS.tau_interaction_nm, PERIOD_S)
    state = hand.read()
    shares = np.array([0.099, 0.2, -0.9])
    state = dataclasses.replace(state, tau_interaction_nm=shares * LIMITS.tau_interaction_nm)
    assert np.array_equal(holding.command(state, 8).q_rad, held.q_rad), (
        "nothing gives way before it is lowered"
    )
    holding.lowering = True
    first = holding.command(state, 9)
    assert first.seq == 9
    assert np.rad2deg(first.dq_rad_s) == pytest.approx([0.0, -20.0 * 0.2 / 0.3, 20.0])
    assert first.q_rad - held.q_rad == pytest.approx(first.dq_rad_s * PERIOD_S)
    assert first.tau_ff_nm / 0.02 == pytest.approx([1.0, 1.0 - 1e-3 / 0.5, 1.0 - 1e-3 / 0.5])
    again = holding.command(state, 10)
    assert again.q_rad - first.q_rad == pytest.approx(first.dq_rad_s * PERIOD_S)
