"""Gains: refused before motion where unstable, and stable in simulation with delay to spare."""

from __future__ import annotations

import dataclasses
from collections import deque
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from robot_iface.control import (
    FingertipLaw,
    Gains,
    Goal,
    ImpedanceLaw,
    Law,
    check_gains,
    hand_chain,
    make_law,
    nominal_gains,
    thesis_gains,
)
from robot_iface.control.stability import (
    check_joint_gains,
    damping_bound_nms_rad,
    stiffness_bound_nm_rad,
)
from robot_iface.errors import Refused
from robot_iface.kinematics import average_hand
from robot_iface.motion import PathState, Setpoint
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, device_capabilities
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, PatientTwin, Space, VirtualKind

J = len(DRIVEN)
DEVICE = device_capabilities()
LIMITS = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)
SHIPPED = 3.0
"""Stiffness multiple that a prescription has by default."""
STILL = np.zeros(J)
ROTOR, BARE = 3e-4, 1e-4


def spectral_radius(
    stiffness: float,
    damping: float,
    feedback: float = 0.0,
    *,
    finger: float | None = 1e-4,
    period_s: float = 1e-3,
    delay: int = 1,
) -> float:
    """Largest eigenvalue of rotor, strap and finger under a law that is sampled, held and ``delay`` late."""
    strap, strap_d = (5.0, 0.02) if finger else (0.0, 0.0)
    mass = finger or 1e-4
    a = np.zeros((5, 5))
    a[0, 1] = a[2, 3] = 1.0
    a[1, :4] = np.array([-strap, -strap_d - BARE, strap, strap_d]) / ROTOR
    a[3, :4] = np.array([strap, strap_d, -strap - 0.04, -strap_d - 0.002]) / mass
    a[1, 4] = 1.0 / ROTOR
    step = expm(a * period_s)
    law = np.array([-stiffness, -damping, 0.0, 0.0]) - feedback * np.array([strap, strap_d, -strap, -strap_d])
    loop = np.zeros((4 + delay, 4 + delay))
    loop[:4, :4], loop[:4, 4] = step[:4, :4], step[:4, 4]
    for late in range(delay - 1):
        loop[4 + late, 5 + late] = 1.0
    loop[-1, :4] = law
    return float(np.abs(np.linalg.eigvals(loop)).max())


@pytest.mark.parametrize("period_s", [1e-3, 2e-3, 5e-3])
@pytest.mark.parametrize("finger", [None, 1e-5, 1e-4, 3e-4])
def test_what_the_bounds_allow_is_stable_with_a_hand_and_without(
    period_s: float, finger: float | None
) -> None:
    most = damping_bound_nms_rad(period_s, ROTOR)
    for damping in np.geomspace(0.005, most, 6):
        stiffness = float(stiffness_bound_nm_rad(np.array([damping]), period_s)[0])
        assert spectral_radius(stiffness, float(damping), finger=finger, period_s=period_s) < 1.0


def test_the_straps_do_not_count_as_damping() -> None:
    """6.7 Nm/rad, the bound with the straps' 0.02 in it, is not stable on a joint that is hardly damped."""
    assert spectral_radius(6.7, 0.005, finger=None) > 1.0
    assert float(stiffness_bound_nm_rad(np.array([0.005]), 1e-3)[0]) < 1.8


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("finger", [1e-5, 1e-4, 3e-4])
def test_torque_feedback_is_stable_even_with_the_wrong_sign(finger: float, sign: float) -> None:
    for delay in (1, 2, 3):
        assert spectral_radius(0.0, 0.0, 0.95 * sign, finger=finger, delay=delay) < 1.0
    assert spectral_radius(0.0, 0.0, -1.5, finger=finger) > 1.0, "beyond 1 a wrong sign would run away"


@pytest.mark.parametrize("multiple", [0.1, 1.0, 3.0, 10.0])
def test_every_joint_multiple_of_a_prescription_is_stable_at_one_kilohertz(multiple: float) -> None:
    check_gains(multiple, "joint", DRIVEN, 1e-3, ROTOR)


@pytest.mark.parametrize(
    ("multiple", "space", "period_s", "said"),
    [
        (12.0, "joint", 1e-3, "stiffness multiple is 12,.*0.1 to 10"),
        (float("nan"), "joint", 1e-3, "stiffness multiple is nan"),
        (0.5, "fingertip", 1e-3, "fingertip stiffness is 50 N/m.*100 to 800 N/m"),
        (9.0, "fingertip", 1e-3, "fingertip stiffness is 900 N/m.*100 to 800 N/m"),
        (10.0, "joint", 5e-3, "damping of thumb_cmc_flexion is 0.0632 Nms/rad.*below 0.042 Nms/rad at 5 ms"),
        (8.0, "fingertip", 2e-3, "damping of .* Nms/rad.*below 0.105 Nms/rad at 2 ms"),
    ],
)
def test_gains_out_of_range_or_unstable_are_refused(
    multiple: float, space: Space, period_s: float, said: str
) -> None:
    with pytest.raises(Refused, match=said):
        check_gains(multiple, space, DRIVEN, period_s, ROTOR)


def test_stiffness_is_named_where_it_is_what_breaks_the_bound() -> None:
    gains = Gains(np.array([0.3, 2.0]), np.array([0.02, 0.005]))
    with pytest.raises(Refused, match=r"stiffness of index_pip is 2 Nm/rad.*below 1.7 Nm/rad at 1 ms"):
        check_joint_gains(gains, ("index_mcp_flexion", "index_pip"), 1e-3, ROTOR)


def test_a_lighter_motor_bears_less_damping() -> None:
    check_gains(8.0, "joint", DRIVEN, 1e-3, 3e-4)
    with pytest.raises(Refused, match=r"damping of .* Nms/rad.*below 0.028 Nms/rad at 1 ms"):
        check_gains(8.0, "joint", DRIVEN, 1e-3, 4e-5)


def test_the_law_of_a_plan_is_checked_for_the_inertia_of_its_device(make_plan: Any) -> None:
    plan = make_plan(multiple=8.0)
    make_law(plan, DEVICE)
    with pytest.raises(Refused, match="damping of thumb_cmc_flexion"):
        make_law(plan, dataclasses.replace(DEVICE, inertia_kg_m2=4e-5))


def test_no_posture_is_stiffer_at_the_joints_than_what_is_checked() -> None:
    rng = np.random.default_rng(4)
    most = nominal_gains(DRIVEN, "fingertip")
    law = FingertipLaw(hand_chain(DRIVEN, average_hand(0.21)), LIMITS)
    for _ in range(200):
        q = rng.uniform(DEVICE.q_min_rad, DEVICE.q_max_rad)
        command = law.command(reading(q), goal(q, 1.0), 1.0, 0)
        assert np.all(command.stiffness_nm_rad <= most.stiffness_nm_rad + 1e-12)
        assert np.all(command.damping_nms_rad <= most.damping_nms_rad + 1e-12)


def reading(q: np.ndarray) -> DeviceState:
    return DeviceState(0, 0, q, q, STILL, STILL, STILL, 30.0, ())


def goal(q: np.ndarray, multiple: float, feedback: float = 0.0) -> Goal:
    at = PathState(0.0, 0.0, 0.0, False)
    return Goal(Setpoint(q, STILL, STILL), STILL + multiple, STILL, at, feedback)


def torque(command: DeviceCommand, state: DeviceState) -> np.ndarray:
    spring = command.stiffness_nm_rad * (command.q_rad - state.q_rad)
    return spring + command.damping_nms_rad * (command.dq_rad_s - state.dq_rad_s) + command.tau_ff_nm


def speeds_after_a_kick(
    law: Law, kind: VirtualKind, multiple: float, delay: int, *, worn: bool = True, feedback: float = 0.0
) -> np.ndarray:
    """Speeds, (1500, J), of a loop that is closed here, with torques that reach the motors ``delay`` late.

    From 0.3 to 0.4 s the goal stands 0.15 rad aside.
    """
    robot = SimulatedExoskeleton(PatientTwin(kind), 1)
    robot.open()
    robot.enable()
    if not worn:  # nobody's hand is in it: the straps carry nothing
        robot._model.tendon_stiffness[:J] = 0.0
        robot._model.tendon_damping[:J] = 0.0
    waiting: deque[DeviceCommand] = deque()
    start, speeds = robot.read().q_rad, []
    for tick in range(1500):
        robot.advance()
        state = robot.read()
        aside = 0.15 if 300 <= tick < 400 else 0.0
        command = law.command(state, goal(start + aside, multiple, feedback), min(tick / 200, 1.0), tick)
        tau = np.clip(torque(command, state), -0.6, 0.6)
        waiting.append(dataclasses.replace(command, mode=CommandMode.TORQUE, tau_ff_nm=tau))
        if len(waiting) > delay:
            robot.write(waiting.popleft())
        speeds.append(state.dq_rad_s)
    return np.array(speeds)


@pytest.mark.parametrize(
    ("kind", "worn"), [("healthy", True), ("flaccid", True), ("mas2", True), ("flaccid", False)]
)
@pytest.mark.parametrize("times", [2.0, 3.0])
@pytest.mark.parametrize("space", ["joint", "fingertip"])
def test_twice_and_three_times_the_shipped_gains_bear_an_extra_tick(
    kind: VirtualKind, worn: bool, times: float, space: Space
) -> None:
    tip = FingertipLaw(hand_chain(DRIVEN, average_hand()), LIMITS)
    law = tip if space == "fingertip" else ImpedanceLaw(thesis_gains(DRIVEN), LIMITS)
    speeds = np.abs(speeds_after_a_kick(law, kind, SHIPPED * times, 1, worn=worn))
    assert speeds[300:500].max() > 1.0, "the kick is felt"
    assert speeds[-300:].max() < 0.05, "and dies away to the noise of the sensors"


@pytest.mark.parametrize("kind", ["healthy", "flaccid", "mas2"])
def test_torque_feedback_bears_two_ticks(kind: VirtualKind) -> None:
    law = ImpedanceLaw(thesis_gains(DRIVEN), LIMITS)
    speeds = np.abs(speeds_after_a_kick(law, kind, 0.5, 2, feedback=0.8))
    assert speeds[-300:].max() < 0.05
