"""A hand let go of, braked, or seized by a spasm comes to rest or shakes within bounds, whoever it is."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest

from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton
from robot_iface.types import (
    VIRTUAL_KINDS,
    CommandMode,
    DeviceCommand,
    Float64,
    PatientTwin,
    Spasm,
    VirtualKind,
)

OPENED_TICKS = 2500
FREE, BRAKE_NMS_RAD = 0.0, 0.2
SPASM = Spasm(3.2, 0.6, 0.3)


def held_open(kind: VirtualKind, spasms: tuple[Spasm, ...] = ()) -> SimulatedExoskeleton:
    """The fingers opened with 0.9 of the shipped limit and held."""
    robot = SimulatedExoskeleton(PatientTwin(kind, spasms=spasms), 1)
    device = robot.capabilities
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad, spastic=True)
    opens = np.array([not name.startswith("thumb") for name in DRIVEN]) * -0.9 * limits.tau_interaction_nm
    zeros = np.zeros(len(DRIVEN))
    robot.open()
    robot.enable()
    for tick in range(OPENED_TICKS):
        torque = opens * min(tick / 1500.0, 1.0)
        robot.write(DeviceCommand(CommandMode.IMPEDANCE, zeros, zeros, torque, zeros, zeros + 0.05, tick))
        robot.advance()
    return robot


@cache
def let_go(kind: VirtualKind, brake_nms_rad: float, *, seized: bool) -> Float64:
    """True speeds of the hand in the 10 s after, in deg/s, (10000, 21)."""
    robot = held_open(kind, (SPASM,) if seized else ())
    if brake_nms_rad == FREE:
        robot.power_off()
    else:
        robot.brake(brake_nms_rad)
    speeds = np.empty((10_000, 21))
    for row in speeds:
        robot.advance()
        row[:] = robot.hand_speed_rad_s
    return np.rad2deg(speeds)


@pytest.mark.parametrize("seized", [False, True])
@pytest.mark.parametrize("brake_nms_rad", [FREE, BRAKE_NMS_RAD])
@pytest.mark.parametrize("kind", VIRTUAL_KINDS)
def test_no_hand_shakes_without_bound(
    kind: VirtualKind, brake_nms_rad: float, seized: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        speeds = let_go(kind, brake_nms_rad, seized=seized)
    assert np.isfinite(speeds).all()
    assert np.abs(speeds).max() < 2000.0
    assert "WARNING" not in "".join(capfd.readouterr()), "of the physics engine"


@pytest.mark.parametrize("brake_nms_rad", [FREE, BRAKE_NMS_RAD])
@pytest.mark.parametrize("kind", ["mas1+", "mas2", "mas3"])
def test_a_spastic_hand_comes_to_rest(kind: VirtualKind, brake_nms_rad: float) -> None:
    assert np.abs(let_go(kind, brake_nms_rad, seized=True)[-500:]).max() < 5.0


def test_a_clonic_hand_that_snapped_shut_beats_on_at_5_to_7_hz_and_bounded() -> None:
    late = let_go("clonus", FREE, seized=False)[-4000:]
    joint = int(np.abs(late).max(axis=0).argmax())
    spectrum = np.abs(np.fft.rfft(late[:, joint] - late[:, joint].mean()))
    assert 4.9 <= np.fft.rfftfreq(len(late), 0.001)[int(np.argmax(spectrum))] <= 7.1
    assert 20.0 < np.abs(late).max() < 400.0


@pytest.mark.parametrize("kind", ["mas2", "mas3", "contracture"])
def test_the_brake_keeps_the_whole_recoil_at_a_quarter_of_that_without_power(kind: VirtualKind) -> None:
    braked, free = (let_go(kind, damping, seized=False) for damping in (BRAKE_NMS_RAD, FREE))
    assert np.abs(braked).max() <= 0.25 * np.abs(free).max()
    assert np.abs(free).max() <= 1.05 * np.abs(free[:70]).max(), "the first swing is the fastest"
