"""The fingertip law: its kinematics against the hand's own, its torque against the formula."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robot_iface.control import FingertipLaw, Goal, ImpedanceLaw, dlr_hit_chain, hand_chain, make_law
from robot_iface.control.chain import Chain, digit_kinematics
from robot_iface.errors import Refused
from robot_iface.kinematics import DIP_PER_PIP, average_hand, forward, jacobian
from robot_iface.kinematics.dlr_hit import finger_points
from robot_iface.motion import PathState, Setpoint
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import DIGITS, FINGERS, JOINTS, LANDMARKS, DeviceState, Limits, Plan, Side

DLR_HIT = tuple(
    [
        *("thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip"),
        *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_abduction", "mcp_flexion", "pip")),
    ]
)
UNCOUPLED = tuple(JOINTS)
RNG = np.random.default_rng(7)


def wide(names: tuple[str, ...], tau_nm: float = 50.0) -> Limits:
    joints = len(names)
    limits = shipped_limits(names, np.full(joints, -1.0), np.full(joints, 2.0), hyperextension=True)
    return replace(limits, tau_interaction_nm=np.full(joints, tau_nm))


def evaluate(chain: Chain, q: np.ndarray, digit: int) -> np.ndarray:
    out = np.zeros((6, 3))
    digit_kinematics(q, chain.joint, chain.links, digit, out)
    return out


@pytest.mark.parametrize("names", [DRIVEN, UNCOUPLED], ids=["driven", "all 21"])
@pytest.mark.parametrize("side", ["right", "left"])
def test_tips_and_jacobian_are_those_of_the_hand(names: tuple[str, ...], side: Side) -> None:
    hand = average_hand(0.18, side)
    chain = hand_chain(names, hand)
    place = [JOINTS.index(name) for name in names]
    for _ in range(20):
        q = RNG.uniform(-0.4, 1.4, len(names))
        full, spread = np.zeros(21), np.zeros((21, len(names)))
        full[place], spread[place, range(len(names))] = q, 1.0
        for finger in FINGERS:
            if f"{finger}_dip" not in names:
                pip = JOINTS.index(f"{finger}_pip")
                full[pip + 1] = DIP_PER_PIP * full[pip]
                spread[pip + 1] = DIP_PER_PIP * spread[pip]
        slopes, landmarks = jacobian(hand, full) @ spread, forward(hand, full).landmarks_m
        for digit, name in enumerate(DIGITS):
            out = evaluate(chain, q, digit)
            turn = hand.mirror[:, None] * hand.base_rotation[digit]
            tip = LANDMARKS.index(f"{name}_tip")
            base = hand.mirror * hand.bases_m[digit]
            assert np.abs(base + turn @ out[0] - landmarks[tip]).max() < 1e-12
            for slot, column in enumerate(chain.joint[digit]):
                if column >= 0:
                    assert np.abs(turn @ out[1 + slot] - slopes[tip][:, column]).max() < 1e-12


def test_the_dlr_hit_finger_is_the_thesis_s() -> None:
    """Its frame is distal, flexion, dorsal; ours palmar, radial, distal."""
    chain, turn = dlr_hit_chain(DLR_HIT), np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    for digit in range(5):
        q = RNG.uniform(-0.2, 1.2, len(DLR_HIT))
        finger = q[3 * digit : 3 * digit + 3]
        out = evaluate(chain, q, digit)
        assert np.abs(out[0] - turn @ finger_points(finger)[-1]).max() < 1e-12
        for local, slot in enumerate((1, 0, 2)):
            step = np.zeros(3)
            step[local] = 1e-6
            slope = (finger_points(finger + step)[-1] - finger_points(finger - step)[-1]) / 2e-6
            assert np.abs(out[1 + slot] - turn @ slope).max() < 1e-9


def test_a_joint_that_is_no_hand_s_is_refused() -> None:
    with pytest.raises(Refused, match="joint is elbow_flexion"):
        hand_chain(("elbow_flexion",), average_hand())


def state_at(q: np.ndarray, dq: np.ndarray) -> DeviceState:
    return DeviceState(0, 0, q, q, dq, np.zeros(q.size), np.zeros(q.size), 30.0, ())


def dense(chain: Chain, q: np.ndarray, digit: int) -> tuple[np.ndarray, np.ndarray]:
    """Tip and (3, J) Jacobian of a digit."""
    out, slopes = evaluate(chain, q, digit), np.zeros((3, q.size))
    for slot, column in enumerate(chain.joint[digit]):
        if column >= 0:
            slopes[:, column] += out[1 + slot]
    return out[0], slopes


def wanted_nm(chain: Chain, multiples: np.ndarray, *at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Spring and damper torque by the formula; ``at``: q, dq, q_d, dq_d."""
    q, dq, q_d, dq_d = at
    spring = 0.03 * multiples * (q_d - q)
    damper = 0.0063 * np.sqrt(multiples) * (dq_d - dq)
    for digit in range(5):
        columns = [column for column in chain.joint[digit] if column >= 0]
        stiffness = 100.0 * multiples[columns].min()
        damping = 2 * 0.7 * np.sqrt(0.06 * stiffness)
        (x, here), (x_d, there) = dense(chain, q, digit), dense(chain, q_d, digit)
        spring = spring + here.T @ (stiffness * (x_d - x))
        damper = damper + here.T @ (damping * (there @ dq_d - here @ dq))
    return spring, damper


@pytest.mark.parametrize("names", [DRIVEN, DLR_HIT], ids=["hand", "dlr-hit-ii"])
def test_the_command_says_the_torque_of_the_formula(names: tuple[str, ...]) -> None:
    worn = names is DRIVEN
    chain = hand_chain(names, average_hand()) if worn else dlr_hit_chain(names)
    law = FingertipLaw(chain, wide(names))
    for _ in range(10):
        q, q_d = RNG.uniform(0.0, 1.3, (2, len(names)))
        dq, dq_d = RNG.uniform(-1.0, 1.0, (2, len(names)))
        multiples, ff = RNG.uniform(0.5, 4.0, len(names)), RNG.uniform(-0.1, 0.1, len(names))
        goal = Goal(Setpoint(q_d, dq_d, dq), multiples, ff, PathState(0.0, 0.0, 0.0, False))
        for ramp in (0.0, 0.4, 1.0):
            command = law.command(state_at(q, dq), goal, ramp, 5)
            spring, damper = wanted_nm(chain, multiples * ramp, q, dq, q_d, dq_d)
            assert np.allclose(command.stiffness_nm_rad * (command.q_rad - q), spring, atol=1e-9)
            assert np.allclose(command.damping_nms_rad * (command.dq_rad_s - dq), damper, atol=1e-9)
            assert np.allclose(command.tau_ff_nm, ff * ramp)
        assert command.seq == 5


def test_each_joint_is_as_stiff_as_its_fingertip_makes_it() -> None:
    chain = hand_chain(DRIVEN, average_hand())
    q, still = RNG.uniform(0.1, 1.0, len(DRIVEN)), np.zeros(len(DRIVEN))
    goal = Goal(Setpoint(q, still, still), still + 3.0, still, PathState(0.0, 0.0, 0.0, False))
    command = FingertipLaw(chain, wide(DRIVEN)).command(state_at(q, still), goal, 1.0, 0)
    expected = still + 0.09
    for digit in range(5):
        expected = expected + 300.0 * (dense(chain, q, digit)[1] ** 2).sum(axis=0)
    assert np.allclose(command.stiffness_nm_rad, expected)


def test_the_spring_saturates_per_joint_below_the_patients_limit() -> None:
    limits = wide(DRIVEN, 0.2)
    law = FingertipLaw(hand_chain(DRIVEN, average_hand()), limits)
    q, still = np.full(len(DRIVEN), 0.2), np.zeros(len(DRIVEN))
    goal = Goal(Setpoint(q + 0.9, still, still), still + 8.0, still, PathState(0.0, 0.0, 0.0, False))
    command = law.command(state_at(q, still), goal, 1.0, 0)
    spring = command.stiffness_nm_rad * (command.q_rad - q)
    assert np.abs(spring).max() == pytest.approx(0.9 * 0.2)


def test_the_straight_finger_is_held_by_the_weak_joint_spring() -> None:
    """There the tip does not feel MCP against PIP."""
    chain = hand_chain(DRIVEN, average_hand())
    law, still = FingertipLaw(chain, wide(DRIVEN)), np.zeros(len(DRIVEN))
    slopes = dense(chain, still, 1)[1]
    mcp, pip = DRIVEN.index("index_mcp_flexion"), DRIVEN.index("index_pip")
    blind = still.copy()
    blind[mcp], blind[pip] = slopes[0, pip], -slopes[0, mcp]
    blind *= 0.01 / np.linalg.norm(blind)
    goal = Goal(Setpoint(blind, still, still), still + 1.0, still, PathState(0.0, 0.0, 0.0, False))
    command = law.command(state_at(still, still), goal, 1.0, 0)
    spring = command.stiffness_nm_rad * command.q_rad
    assert spring @ blind >= 0.99 * 0.03 * blind @ blind


def test_a_plan_gets_the_law_that_it_prescribes(make_plan) -> None:
    plan: Plan = make_plan()
    tip = replace(plan, prescription=replace(plan.prescription, space="fingertip"))
    worn = device_capabilities()
    assert isinstance(make_law(plan, worn), ImpedanceLaw)
    assert isinstance(make_law(tip, worn), FingertipLaw)
    hit = replace(worn, joint_names=DLR_HIT, chain="dlr-hit-ii", worn=False)
    shown = replace(tip, limits=wide(DLR_HIT))
    assert isinstance(make_law(shown, hit), FingertipLaw)
    for wrong in (
        replace(tip.prescription, stiffness_multiple=9.0),
        replace(tip.prescription, space="joint"),
    ):
        slow = replace(worn, period_ns=20_000_000)
        with pytest.raises(Refused, match=r"(stiffness|damping)"):
            make_law(replace(tip, prescription=wrong), slow)
