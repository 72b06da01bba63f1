"""What distinguishes the virtual patients."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.sim import DRIVEN, Fault, SimulatedExoskeleton, virtual_patient
from robot_iface.sim.effort import COMMAND_DELAY_TICKS, REFLEX_DELAY_TICKS, PatientEffort, patient_spasms
from robot_iface.types import (
    VIRTUAL_KINDS,
    CommandMode,
    DeviceCommand,
    Float64,
    PatientTwin,
    Spasm,
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
    speeds = {"slow": -np.deg2rad(25.0), "fast": -np.deg2rad(90.0), "flexing": np.deg2rad(90.0)}
    for speed in speeds.values():
        effort = PatientEffort(virtual_patient("mas2"), np.zeros(12), np.random.default_rng(0))
        torques = [effort.torque_nm(np.zeros(12), np.full(12, speed))[MCP] for _ in range(600)]
        full = virtual_patient("mas2").spasticity_nms_rad * max(-speed - np.deg2rad(30.0), 0.0)
        assert torques[-1] == pytest.approx(full, abs=1e-6)
        assert not any(torques[:REFLEX_DELAY_TICKS]), "late"
        assert torques[REFLEX_DELAY_TICKS + 50] == pytest.approx(0.5 * full, abs=0.01), "as a twitch rises"


@pytest.mark.parametrize("kind", ["mas2", "mas3", "clonus"])
def test_no_stretch_calls_for_more_than_a_reflex_can_give(kind: VirtualKind) -> None:
    effort = PatientEffort(virtual_patient(kind), np.zeros(12), np.random.default_rng(0))
    torques = [effort.torque_nm(np.zeros(12), np.full(12, -200.0)) for _ in range(600)]
    most = np.array(torques).max(axis=0) - virtual_patient(kind).clonus_nm
    assert most[MCP] <= 0.5
    assert most[MCP + 1] <= 0.3
    assert np.array(torques[-1]).min() > 0.2


def test_a_spindle_slackened_by_a_fast_flexion_is_taut_again_after_a_while() -> None:
    """What keeps a hand that snapped shut from shaking on; a movement of therapy does not slacken it."""
    peaks: list[float] = []
    for flexes_deg_s, rests_s in ((60.0, 0.1), (300.0, 0.1), (300.0, 12.0)):
        effort = PatientEffort(virtual_patient("mas2"), np.zeros(12), np.random.default_rng(0))
        last = 0.0
        for speed, ticks in ((flexes_deg_s, 100), (0.0, round(1000 * rests_s)), (-90.0, 200)):
            for _ in range(ticks):
                last = effort.torque_nm(np.zeros(12), np.full(12, np.deg2rad(speed)))[MCP]
        peaks.append(float(last))
    assert peaks[1] < 0.1 * peaks[0]
    assert peaks[2] > 0.9 * peaks[0]


def spasm_of(size_nm: float, speed_rad_s: float) -> Float64:
    rows = patient_spasms((Spasm(0.0, 9.0, size_nm),))
    effort = PatientEffort(virtual_patient("flaccid"), np.zeros(12), np.random.default_rng(0), rows)
    return effort.torque_nm(np.zeros(12), np.full(12, speed_rad_s))


def test_no_muscle_is_stronger_or_faster_than_muscles_are() -> None:
    assert spasm_of(0.9, 0.0)[MCP] == 0.9
    assert spasm_of(9.0, 0.0)[MCP] == 2.0
    assert spasm_of(9.0, 0.0)[MCP + 1] == 1.0
    assert spasm_of(-9.0, 0.0)[MCP] == -1.0
    assert spasm_of(0.9, 10.0)[MCP] == 0.9, "all, at whatever a supervised hand does"
    assert spasm_of(0.9, 17.5)[MCP] == pytest.approx(0.45)
    assert spasm_of(0.9, 30.0)[MCP] == 0.0
    assert spasm_of(0.9, -30.0)[MCP] == 0.9, "lengthened it gives all"


def left_behind(by_rad: float) -> list[float]:
    """Willingness of a slacking patient at each cue whose hand lags a movement of 0.5 rad by so much."""
    effort = PatientEffort(virtual_patient("slacking"), np.zeros(12), np.random.default_rng(0))
    path, willing = np.linspace(0.0, 0.5, 101)[:, None] * np.ones(12), []
    for _ in range(9):
        effort.cue(path, 0.01, 1.0)
        willing.append(effort.willingness)
        for tick in range(1000):
            effort.progress(tick * 0.001)
            effort.torque_nm(path[tick // 10] - by_rad, np.full(12, 0.5))
        effort.relax()
    return willing


def test_a_slacking_patient_gives_the_less_the_better_the_robot_does_it() -> None:
    helped, partly, alone = left_behind(0.0), left_behind(0.1), left_behind(0.4)
    assert all(later < earlier for earlier, later in itertools.pairwise(helped))
    assert helped[-1] < 0.05
    assert partly[-1] == pytest.approx(0.1 / 0.3, abs=0.05), "where falling off and being roused balance"
    assert alone[-1] == 1.0
    ahead = left_behind(-0.4)
    assert ahead == pytest.approx(helped), "who is ahead is not left behind"


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
    assert speeds[1] < 0.33 * speeds[0]
