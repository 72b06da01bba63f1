"""What distinguishes the virtual patients."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.sim import DRIVEN, Fault, SimulatedExoskeleton, virtual_patient
from robot_iface.sim.effort import COMMAND_DELAY_TICKS, REFLEX_DELAY_TICKS, PatientEffort
from robot_iface.types import (
    VIRTUAL_KINDS,
    CommandMode,
    DeviceCommand,
    Float64,
    PatientTwin,
    VirtualKind,
    joint_index,
)

MCP = DRIVEN.index("index_mcp_flexion")


def driven_rest(kind: str) -> Float64:
    return virtual_patient(kind).rest_rad()[joint_index(DRIVEN)]


def free_hand(kind: VirtualKind, seed: int = 1) -> SimulatedExoskeleton:
    robot = SimulatedExoskeleton(PatientTwin(kind), seed)
    robot.open()
    return robot


@pytest.mark.parametrize("kind", VIRTUAL_KINDS)
def test_every_kind_is_built_and_stays_finite(kind: VirtualKind) -> None:
    robot = free_hand(kind)
    robot.patient.cue(driven_rest(kind) + np.linspace(0, 0.5, 200)[:, None], 0.005, 1.0)
    for _ in range(1500):
        robot.advance()
    assert np.isfinite(robot.read().q_rad).all()
    assert np.abs(robot.read().q_rad).max() < 2.0


def test_an_unknown_kind_is_refused_with_the_list_of_those_that_exist() -> None:
    with pytest.raises(Refused, match=r"healthy.*mas2"):
        virtual_patient("sleepy")


def test_the_same_seed_reads_the_same_and_another_does_not() -> None:
    readings = []
    for seed in (3, 3, 4):
        robot = free_hand("tremor", seed)
        for _ in range(500):
            robot.advance()
        readings.append(np.concatenate([robot.read().q_rad, robot.hand_rad]))
    np.testing.assert_array_equal(readings[0], readings[1])
    assert np.abs(readings[0][-21:] - readings[2][-21:]).max() > 1e-4


def moved_after_cue(kind: VirtualKind, seconds: float = 2.0) -> float:
    robot = free_hand(kind)
    goals = driven_rest(kind) + np.linspace(0.0, 0.5, 200)[:, None]
    robot.patient.cue(goals, 0.005, 1.0)
    start = robot.hand_rad
    for _ in range(int(1000 * seconds)):
        robot.advance()
    return float(np.rad2deg(np.abs(robot.hand_rad - start).max()))


def test_ability_shows_in_the_movement_after_the_cue() -> None:
    assert moved_after_cue("healthy") > moved_after_cue("weak") > 3.0 > moved_after_cue("mas3")
    assert moved_after_cue("flaccid") < 0.1


def test_nobody_moves_before_the_command_delay() -> None:
    assert moved_after_cue("healthy", (COMMAND_DELAY_TICKS - 2) / 1000) < 1e-9


def test_the_reflex_opposes_fast_extension_late_and_only_then() -> None:
    effort = PatientEffort(virtual_patient("mas2"), np.zeros(12), np.random.default_rng(0))
    speeds = {"slow": -np.deg2rad(25.0), "fast": -np.deg2rad(90.0), "flexing": np.deg2rad(90.0)}
    for speed in speeds.values():
        late = [effort.torque_nm(np.zeros(12), np.full(12, speed)) for _ in range(REFLEX_DELAY_TICKS + 1)]
        torque = late[-1]
        excess = max(-speed - np.deg2rad(30.0), 0.0)
        assert torque[MCP] == pytest.approx(virtual_patient("mas2").spasticity_nms_rad * excess, abs=1e-12)


def test_a_slacking_patient_gives_less_each_time() -> None:
    effort = PatientEffort(virtual_patient("slacking"), np.zeros(12), np.random.default_rng(0))
    pulls: list[float] = []
    torque = np.zeros(12)
    for _ in range(4):
        effort.cue(np.full((10, 12), 0.3), 0.005, 1.0)
        for _ in range(1500):
            torque = effort.torque_nm(np.zeros(12), np.zeros(12))
        pulls.append(float(torque[MCP]))
    assert all(later < earlier for earlier, later in itertools.pairwise(pulls))


def hold_command(robot: SimulatedExoskeleton, stiffness: float) -> DeviceCommand:
    gains = np.full(12, stiffness)
    return DeviceCommand(
        CommandMode.IMPEDANCE, robot.read().q_rad, np.zeros(12), np.zeros(12), gains, 0.03 * np.sqrt(gains), 1
    )


def test_interaction_torque_is_what_holds_a_spasm() -> None:
    spasm = Fault("spasm", 0.2, 5.0, "index_mcp_flexion", 0.1)
    robot = SimulatedExoskeleton(PatientTwin("healthy"), 1, [spasm])
    robot.open()
    robot.enable()
    robot.write(hold_command(robot, 3.0))
    for _ in range(2000):
        robot.advance()
    state = robot.read()
    given = float(np.median([state.tau_interaction_nm[MCP]]))
    passive = 0.04 * (robot.hand_rad[6 - 1] - driven_rest("healthy")[MCP])
    assert given == pytest.approx(-(0.1 - passive), abs=0.004)


def test_unpowered_motors_ignore_commands_and_the_brake_only_damps() -> None:
    robot = free_hand("healthy")
    robot.write(hold_command(robot, 3.0))
    robot.advance()
    assert not robot.read().tau_nm.any()
    spasm = Fault("spasm", 0.0, 5.0, "", 0.2)
    speeds = []
    for damping in (0.0, 0.2):
        robot = SimulatedExoskeleton(PatientTwin("healthy"), 1, [spasm])
        robot.open()
        robot.enable()
        robot.brake(damping)
        top = 0.0
        for _ in range(150):
            robot.advance()
            top = max(top, float(np.abs(robot.hand_speed_rad_s).max()))
        speeds.append(top)
    assert speeds[1] < 0.25 * speeds[0]
