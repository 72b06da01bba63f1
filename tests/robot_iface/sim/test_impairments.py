"""Contracture, clonus, fatigue, spasms and measured stiffness of the virtual patient."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.kinematics import DIP_PER_PIP, forward, patient_hand
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, patient_of, virtual_patient
from robot_iface.sim.effort import PatientEffort, patient_spasms
from robot_iface.sim.muscles import REFLEX_DELAY_TICKS
from robot_iface.types import (
    JOINTS,
    CommandMode,
    DeviceCommand,
    Float64,
    PatientTwin,
    Spasm,
    VirtualKind,
)

MCP = DRIVEN.index("index_mcp_flexion")
RELAXED_TICKS = 400  # so long after a stretch no muscle answers its reflex any more
HAND_MCP = JOINTS.index("index_mcp_flexion")


def pushed(kind: VirtualKind, torque_nm: float, seconds: float = 2.0) -> SimulatedExoskeleton:
    robot = SimulatedExoskeleton(PatientTwin(kind), 1)
    robot.open()
    robot.enable()
    zeros = np.zeros(12)
    robot.write(DeviceCommand(CommandMode.TORQUE, zeros, zeros, np.full(12, torque_nm), zeros, zeros, 1))
    for _ in range(round(seconds * 1000)):
        robot.advance()
    return robot


def extended_deg(kind: VirtualKind, torque_nm: float) -> float:
    robot = pushed(kind, -torque_nm)
    return float(np.rad2deg(virtual_patient(kind).rest_rad()[HAND_MCP] - robot.hand_rad[HAND_MCP]))


def test_a_contracture_ends_25_degrees_from_rest_whatever_pulls() -> None:
    before, at, beyond = (extended_deg("contracture", torque) for torque in (0.1, 0.2, 0.4))
    assert before < 24.0
    assert 25.0 < at < 27.0
    assert 25.0 < beyond < 30.0
    assert extended_deg("mas1+", 0.1) > 40.0, "without a contracture the same hand opens"
    assert extended_deg("contracture", -0.2) < -30.0, "it closes freely"


def stretch(kind: VirtualKind, speed_deg_s: float, seconds: float, seed: int = 1) -> Float64:
    """Muscle torque at the index MCP after 0.2 s of extension at a speed, then held, (ticks,)."""
    effort = PatientEffort(virtual_patient(kind), np.zeros(12), np.random.default_rng(seed))
    torques = np.empty(round(seconds * 1000))
    for tick in range(torques.size):
        speed = -np.deg2rad(speed_deg_s) if tick < 200 else 0.0
        torques[tick] = effort.torque_nm(np.zeros(12), np.full(12, speed))[MCP]
    return torques[200 + REFLEX_DELAY_TICKS + RELAXED_TICKS :]


def test_clonus_beats_at_5_to_7_hz_after_a_fast_stretch_and_fades() -> None:
    for seed in range(8):
        torque = stretch("clonus", 120.0, 3.0, seed)
        spectrum = np.abs(np.fft.rfft((torque - torque.mean())[:2000]))
        peak_hz = np.fft.rfftfreq(2000, 0.001)[int(np.argmax(spectrum))]
        assert 4.9 <= peak_hz <= 7.1
        assert torque.min() >= 0.0, "it pulls into flexion and never pushes"
        assert torque[:500].max() > 3.0 * torque[-500:].max()


def test_clonus_needs_a_fast_stretch_and_a_clonic_hand() -> None:
    assert not stretch("clonus", 25.0, 1.0).any()
    assert stretch("mas1+", 120.0, 1.0).max() < 1e-5
    assert stretch("clonus", 120.0, 1.0).max() > 0.03


def worked(repetitions: int, every_s: float) -> PatientEffort:
    """A tiring patient who follows a movement of 0.6 rad and back in 2 s, again and again."""
    effort = PatientEffort(virtual_patient("tiring"), np.zeros(12), np.random.default_rng(0))
    u = np.linspace(0.0, 2.0 * np.pi, 2000)
    angles, speeds = 0.3 - 0.3 * np.cos(u), 0.3 * np.pi * np.sin(u)
    for _ in range(repetitions):
        effort.cue(np.full((2, 12), 0.6), 1.0, 1.0)
        for angle, speed in zip(angles, speeds, strict=True):
            effort.torque_nm(np.full(12, angle), np.full(12, speed))
        effort.relax()
        rest(effort, every_s - 2.0)
    return effort


def rest(effort: PatientEffort, seconds: float) -> None:
    zeros = np.zeros(12)
    for _ in range(round(seconds * 1000)):
        effort.torque_nm(zeros, zeros)


def test_a_tiring_patient_loses_ability_by_working_and_regains_it_by_resting() -> None:
    abilities = [worked(repetitions, 3.0).ability for repetitions in (0, 2, 4)]
    assert abilities[0] == 0.7
    assert all(np.diff(abilities) < -0.02)
    tired = worked(4, 3.0)
    rest(tired, 120.0)
    regained = (tired.ability - abilities[-1]) / (abilities[0] - abilities[-1])
    assert 0.1 < regained < 0.3, "a fifth in two of ten minutes"


def test_others_do_not_tire() -> None:
    robot = SimulatedExoskeleton(PatientTwin("healthy"), 1)
    robot.patient.cue(np.ones((10, 12)), 0.01, 1.0)
    for _ in range(500):
        robot.advance()
    assert robot.patient.ability == 0.9


def spasm_torque(spasm: Spasm, seconds: float = 2.0) -> Float64:
    effort = PatientEffort(
        virtual_patient("flaccid"), np.zeros(12), np.random.default_rng(0), patient_spasms((spasm,))
    )
    return np.array([effort.torque_nm(np.zeros(12), np.zeros(12)) for _ in range(round(seconds * 1000))])


def test_a_spasm_has_its_size_time_joint_and_beat() -> None:
    steady = spasm_torque(Spasm(0.5, 0.3, 0.4))
    assert (steady[500:800, MCP] == 0.4).all()
    assert not steady[:500].any()
    assert not steady[800:].any()
    assert not steady[:, DRIVEN.index("thumb_cmc_abduction")].any(), "it is no joint of flexion"
    single = spasm_torque(Spasm(0.0, 9.0, 0.4, "index_pip"))
    assert (single != 0.0).any(axis=0).sum() == 1
    beating = spasm_torque(Spasm(0.0, 2.0, 0.4, clonus_hz=6.0))[:, MCP]
    assert beating.max() == pytest.approx(0.4, abs=1e-4)
    assert beating.min() == pytest.approx(0.0, abs=1e-4)
    assert (np.diff(np.sign(beating - 0.2)) > 0).sum() == 12


def test_spasms_of_the_record_pull_at_the_hand() -> None:
    quiet, pulled = (
        SimulatedExoskeleton(PatientTwin("healthy", spasms=spasms), 1)
        for spasms in ((), (Spasm(0.1, 0.5, 0.1),))
    )
    for _ in range(500):
        quiet.advance()
        pulled.advance()
    assert (pulled.hand_rad - quiet.hand_rad)[HAND_MCP] > 0.3


def test_a_spasm_of_a_joint_that_is_not_driven_is_refused() -> None:
    with pytest.raises(Refused, match=r"joint of a spasm.*index_toe"):
        SimulatedExoskeleton(PatientTwin(spasms=(Spasm(0.0, 1.0, 0.1, "index_toe"),)), 1)


@pytest.mark.parametrize("stiffness", [0.03, 0.2, 0.52, 0.9])
def test_a_measured_stiffness_replaces_that_of_the_kind(stiffness: float) -> None:
    twin = PatientTwin("flaccid", stiffness_nm_rad=stiffness)
    assert patient_of(twin).stiffness_nm_rad == stiffness
    robot = SimulatedExoskeleton(twin, 1)
    robot.open()
    robot.enable()
    zeros, torque = np.zeros(12), np.full(12, 0.4 * stiffness)
    robot.write(DeviceCommand(CommandMode.TORQUE, zeros, zeros, torque, zeros, zeros, 1))
    start = robot.hand_rad
    for _ in range(4000):
        robot.advance()
    assert (robot.hand_rad - start)[HAND_MCP] == pytest.approx(0.4, abs=0.005)


@pytest.mark.parametrize("stiffness", [-0.1, 0.001, 9.0, float("nan")])
def test_a_stiffness_of_no_hand_is_refused(stiffness: float) -> None:
    with pytest.raises(Refused, match=r"stiffness.*Nm/rad"):
        SimulatedExoskeleton(PatientTwin(stiffness_nm_rad=stiffness), 1)


def test_the_hand_inside_has_the_bones_of_the_record() -> None:
    bones = tuple(tuple(0.9 * value for value in row) for row in patient_hand(PatientTwin()).bones_m.tolist())
    twin = PatientTwin("mas2", "left", bones_m=bones)
    robot = SimulatedExoskeleton(twin, 1)
    for _ in range(20):
        robot.advance()
    expected = forward(patient_hand(twin), robot.hand_rad).landmarks_m
    assert np.abs(robot.landmarks_m - expected[:20]).max() < 1e-9


def test_the_distal_joint_follows_the_middle_one() -> None:
    robot = pushed("healthy", 0.02)
    hand = robot.hand_rad
    pip = JOINTS.index("index_pip")
    assert hand[pip + 1] == pytest.approx(DIP_PER_PIP * hand[pip], abs=0.01)


@pytest.mark.parametrize("kind", ["clonus", "tiring", "contracture", "tremor"])
def test_the_same_seed_is_the_same_run_to_the_last_bit(kind: VirtualKind) -> None:
    spasms = (Spasm(0.2, 0.3, 0.2, clonus_hz=6.0),)
    twin = PatientTwin(kind, axis_offset_m=(0.004, 0.0), strap_slip_rad=0.1, slip_at_s=0.3, spasms=spasms)
    ends = []
    for _ in range(2):
        robot = SimulatedExoskeleton(twin, 5)
        robot.patient.cue(np.full((20, 12), 0.8), 0.02, 1.0)
        for _ in range(800):
            robot.advance()
        state = robot.read()
        ends.append(np.concatenate([robot.hand_rad, state.q_rad, state.tau_interaction_nm]))
    assert ends[0].tobytes() == ends[1].tobytes()
