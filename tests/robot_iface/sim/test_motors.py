"""Warmth of the motors and noise of the sensors."""

from __future__ import annotations

import numpy as np

from robot_iface.sim import SimulatedDlrHit
from robot_iface.sim.motors import ENCODER_STD_RAD, SensorNoise
from robot_iface.types import CommandMode, DeviceCommand


def test_noise_has_its_size_and_never_comes_again() -> None:
    noise = SensorNoise(np.random.default_rng(3), 15)
    rows = []
    for tick in range(1, 4001):
        noise.advance(tick)
        rows.append(noise.now(tick).copy())
    every = np.array(rows)
    assert np.unique(every[:, 0, 0]).size == 4000
    np.testing.assert_allclose(every.std(axis=(0, 2)), [ENCODER_STD_RAD, 1e-3, 2e-3], rtol=0.03)


def test_motors_warm_up_under_load_and_cool_down_without() -> None:
    robot = SimulatedDlrHit(1)
    robot.open()
    robot.enable()
    zeros = np.zeros(15)
    warmth = [robot.read().temperature_c]
    for torque in (0.5, 0.0):
        robot.write(DeviceCommand(CommandMode.TORQUE, zeros, zeros, zeros + torque, zeros, zeros, 1))
        for _ in range(3000):
            robot.advance()
        warmth.append(robot.read().temperature_c)
    assert warmth[1] - warmth[0] > 0.5
    assert warmth[0] < warmth[2] < warmth[1]
