"""Straps on axes that do not meet: geometry, energy, and what a sensor and the hand then show."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.kinematics import patient_hand
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, device_capabilities
from robot_iface.sim.kernels import (
    STRAP_AXIAL_N_M,
    STRAP_STIFFNESS_NM_RAD,
    slipped,
    strap_geometry,
    strap_load,
)
from robot_iface.sim.straps import strap_rows
from robot_iface.types import CommandMode, DeviceCommand, Float64, PatientTwin, joint_index

CAPABILITIES = device_capabilities()
RANGE = (CAPABILITIES.q_min_rad, CAPABILITIES.q_max_rad)
MCP = DRIVEN.index("index_mcp_flexion")
OFFSETS = [(0.010, 0.0), (0.004, 0.006), (-0.008, 0.003), (0.005, -0.005)]


def row(distal_m: float, dorsal_m: float, along_m: float = 0.027, skin_m: float = 0.0085) -> Float64:
    return np.array([dorsal_m, distal_m, along_m, skin_m, 0.0, 0.0])


def turned(angle: float, x: float, z: float) -> tuple[float, float]:
    return float(np.cos(angle) * x + np.sin(angle) * z), float(np.cos(angle) * z - np.sin(angle) * x)


@pytest.mark.parametrize(("distal_m", "dorsal_m"), OFFSETS)
def test_the_cuff_stays_on_the_skin_of_the_bone(distal_m: float, dorsal_m: float) -> None:
    strap = row(distal_m, dorsal_m)
    for angle in np.linspace(-0.2, 1.6, 19).tolist():
        bone, turn, slide, sliding = strap_geometry(angle, strap)
        arm = turned(angle, dorsal_m - 0.0085, 0.027 - distal_m)
        across, along = turned(-bone, arm[0] - dorsal_m, arm[1] + distal_m)
        assert across == pytest.approx(-0.0085, abs=1e-12)
        assert along == pytest.approx(0.027 + slide, abs=1e-12)
        step = 1e-6
        ahead, behind = strap_geometry(angle + step, strap), strap_geometry(angle - step, strap)
        assert turn == pytest.approx((ahead[0] - behind[0]) / (2 * step), abs=1e-7)
        assert sliding == pytest.approx((ahead[2] - behind[2]) / (2 * step), abs=1e-9)


def test_axes_that_meet_neither_lead_nor_slide() -> None:
    for angle in (-0.2, 0.0, 0.7, 1.5):
        bone, turn, slide, sliding = strap_geometry(angle, row(0.0, 0.0))
        assert (bone, turn, slide, sliding) == pytest.approx((angle, 1.0, 0.0, 0.0), abs=1e-12)


def energy(link: float, bone: float, strap: Float64) -> float:
    leads, _, slide, _ = strap_geometry(link, strap)
    strain, skin = leads - bone, float(strap[3])
    own = STRAP_STIFFNESS_NM_RAD - STRAP_AXIAL_N_M * skin**2
    return 0.5 * own * strain**2 + 0.5 * STRAP_AXIAL_N_M * (slide + skin * strain) ** 2


@pytest.mark.parametrize(("distal_m", "dorsal_m"), OFFSETS)
def test_the_load_of_a_strap_is_the_slope_of_its_energy(distal_m: float, dorsal_m: float) -> None:
    strap, step = row(distal_m, dorsal_m), 1e-6
    for link, bone in ((0.1, 0.05), (0.8, 0.6), (1.4, 1.0), (-0.1, 0.1)):
        on_bone, on_world, length = strap_load(link, 0.0, bone, 0.0, strap, 0.0)
        by_bone = (energy(link, bone + step, strap) - energy(link, bone - step, strap)) / (2 * step)
        by_link = (energy(link + step, bone, strap) - energy(link - step, bone, strap)) / (2 * step)
        assert on_bone == pytest.approx(-by_bone, abs=1e-7)
        assert on_world == pytest.approx(by_link, abs=1e-7)
        assert link - bone - length == pytest.approx(strap_geometry(link, strap)[0] - bone, abs=1e-12)


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.010, 0.0)])
def test_a_slipped_strap_is_strained_as_if_the_bone_were_bent_more(offset: tuple[float, float]) -> None:
    strap, slip = row(*offset), 0.15
    strap[4], strap[5] = slip, 1.0
    fresh, late = (
        strap_load(0.8, 0.0, 0.5 + slip, 0.0, strap, 0.0),
        strap_load(0.8, 0.0, 0.5, 0.0, strap, 2.0),
    )
    assert fresh[:2] == pytest.approx(late[:2], abs=1e-12)
    assert late[2] == pytest.approx(fresh[2] + slip, abs=1e-12)


def test_a_strap_slips_smoothly_and_stays_slipped() -> None:
    strap = row(0.0, 0.0)
    strap[4], strap[5] = 0.2, 1.0
    assert slipped(strap, 0.99) == 0.0
    assert 0.0 < slipped(strap, 1.1) < slipped(strap, 1.2) < 0.2
    assert slipped(strap, 1.31) == slipped(strap, 9.0) == 0.2


def held(twin: PatientTwin, angle_rad: float, seconds: float = 2.0) -> SimulatedExoskeleton:
    """The device slowly brings every finger's MCP to an angle and stays."""
    robot = SimulatedExoskeleton(twin, 1)
    robot.open()
    robot.enable()
    start = robot.read().q_rad
    zeros = np.zeros(12)
    gains = np.full(12, 6.0)
    moved = np.array([float(name.endswith("_mcp_flexion") and "thumb" not in name) for name in DRIVEN])
    for tick in range(round(seconds * 1000)):
        share = min(tick / 1000.0, 1.0)
        goal = start + share * moved * (angle_rad - start)
        robot.write(DeviceCommand(CommandMode.IMPEDANCE, goal, zeros, zeros, gains, gains * 0.02, tick))
        robot.advance()
    return robot


def hidden_rad(robot: SimulatedExoskeleton) -> Float64:
    """By how much encoders read more than the hand is bent, (12,)."""
    return robot.read().q_rad - robot.hand_rad[joint_index(DRIVEN)]


@pytest.mark.parametrize("angle_deg", [5.0, 35.0, 60.0])
def test_ten_millimetres_off_hide_the_angle_that_geometry_says(angle_deg: float) -> None:
    twin = PatientTwin("flaccid", axis_offset_m=(0.010, 0.0))
    robot = held(twin, float(np.deg2rad(angle_deg)))
    straps = strap_rows(twin, patient_hand(twin), DRIVEN, *RANGE)
    link = float(robot.read().q_rad[MCP])
    expected = link - strap_geometry(link, straps[MCP])[0]
    assert hidden_rad(robot)[MCP] == pytest.approx(expected, abs=np.deg2rad(1.0))
    if angle_deg > 50.0:
        assert abs(expected) > np.deg2rad(8.0)


def test_an_offset_loads_the_sensor_that_nothing_else_would() -> None:
    loads = []
    for offset in ((0.0, 0.0), (0.010, 0.0)):
        robot = held(PatientTwin("flaccid", axis_offset_m=offset), float(np.deg2rad(85.0)))
        loads.append(float(robot.read().tau_interaction_nm[MCP]))
    # the bone is bent 22 degrees less, and yet the device works harder: the cuff drags on the skin
    assert loads[1] > loads[0] + 0.008


def test_at_rest_motors_carry_what_the_sensors_feel_whatever_the_offset() -> None:
    for offset in ((0.0, 0.0), (0.008, 0.004)):
        state = held(PatientTwin("healthy", axis_offset_m=offset), 0.9, 3.0).read()
        np.testing.assert_allclose(state.tau_nm, state.tau_interaction_nm, atol=2e-3)


def test_a_hand_is_put_into_an_offset_device_without_strain() -> None:
    robot = SimulatedExoskeleton(PatientTwin("mas2", axis_offset_m=(0.010, 0.003)), 1)
    state = robot.read()
    flexes = [index for index, name in enumerate(DRIVEN) if not name.endswith("abduction")]
    assert np.abs(hidden_rad(robot)[flexes]).max() > np.deg2rad(5.0)
    assert np.abs(state.tau_interaction_nm).max() < 0.08, "only what has slid along the skin"


def test_a_slip_moves_the_encoder_away_from_the_hand_by_itself() -> None:
    slip = float(np.deg2rad(10.0))
    before = held(PatientTwin("flaccid", strap_slip_rad=slip, slip_at_s=5.0), 0.5)
    after = held(PatientTwin("flaccid", strap_slip_rad=slip, slip_at_s=1.2), 0.5)
    assert hidden_rad(before)[MCP] == pytest.approx(0.0, abs=np.deg2rad(0.5))
    assert hidden_rad(after)[MCP] == pytest.approx(slip, abs=np.deg2rad(0.5))


def test_an_offset_that_no_strap_can_follow_is_refused() -> None:
    with pytest.raises(Refused, match="axis offset"):
        SimulatedExoskeleton(PatientTwin(axis_offset_m=(0.03, 0.0)), 1)
    with pytest.raises(Refused, match="slip"):
        SimulatedExoskeleton(PatientTwin(strap_slip_rad=1.0), 1)
    with pytest.raises(Refused, match="slip"):
        SimulatedExoskeleton(PatientTwin(strap_slip_rad=float("nan")), 1)
