"""What every simulated device has: motors with a brake and a temperature, and noisy sensors."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot_iface.sim.kernels import DAMPING, FEED_FORWARD, GOAL, GOAL_SPEED, SIGN, STIFFNESS
from robot_iface.types import CommandMode, DeviceCommand, Float64, Int64

MOTOR_CAP_NM = 0.6
ENCODER_STD_RAD = 2e-4
_SECOND_SENSOR_STD_RAD = 1e-3
_SPEED_STD_RAD_S = 2e-3
_NOISE_ROWS = 1024
_HEATING_K_PER_NM2_S = 0.9  # copper losses warm the hottest motor ...
_COOLING_PER_S = 0.02  # ... and air cools it
_AMBIENT_C = 25.0


class Motors:
    """Motors that follow the last command, a brake that shorts them, and the hottest one's temperature.

    The brake needs no power; a command is obeyed only with power, and lifts the brake.

    Args:
        model: The compiled model.
        dofs: Where the J joints stand in its speeds, (J,).
        unpowered_damping_nms_rad: What friction of the gears adds while the motors are off.
    """

    def __init__(self, model: Any, dofs: Int64, unpowered_damping_nms_rad: float = 0.0) -> None:
        self._damping: Float64 = model.dof_damping
        self._dofs = dofs
        self._rotor: Float64 = self._damping[dofs].copy()
        self._unpowered = unpowered_damping_nms_rad
        self._powered = self._braked = False
        self.told = np.zeros((5, dofs.size))
        """What the motors are told, as the compiled kernels read it, (5, J)."""
        self.temperature_c = _AMBIENT_C
        """Of the hottest motor."""
        self._damp(0.0)

    def obey(self, command: DeviceCommand) -> None:
        """Follow a command from now on; without power it has no effect."""
        if not self._powered:
            return
        if self._braked:
            self._damp(0.0)
        told = self.told
        told[FEED_FORWARD] = command.tau_ff_nm
        if command.mode != CommandMode.IMPEDANCE:
            told[STIFFNESS] = told[DAMPING] = 0.0
            return
        told[GOAL], told[GOAL_SPEED] = command.q_rad, command.dq_rad_s
        told[STIFFNESS], told[DAMPING] = command.stiffness_nm_rad, command.damping_nms_rad

    def enable(self) -> None:
        """Power on; nothing happens until the first command."""
        self._powered = True
        if not self._braked:
            self._damp(0.0)

    def brake(self, damping_nms_rad: float) -> None:
        """Short the motors through a resistance: damping without a goal, inside the physics and so stable."""
        self.told[:] = 0.0
        self._damp(damping_nms_rad)

    def power_off(self) -> None:
        """Cut the power and release the brake."""
        self._powered = False
        self.told[:] = 0.0
        self._damp(0.0)

    def warm(self, torque_nm: Float64, seconds: float) -> None:
        """Heat of the last seconds under a torque, (J,)."""
        loss = _HEATING_K_PER_NM2_S * float(np.abs(torque_nm).max()) ** 2
        self.temperature_c += seconds * (loss - _COOLING_PER_S * (self.temperature_c - _AMBIENT_C))

    def _damp(self, damping_nms_rad: float) -> None:
        self._braked = damping_nms_rad > 0.0
        gears = 0.0 if self._powered else self._unpowered
        self._damping[self._dofs] = self._rotor + damping_nms_rad + gears


class SensorNoise:
    """Noise of two position sensors and a speed for J joints, drawn in batches.

    Args:
        rng: Where it comes from.
        joints: J.
    """

    def __init__(self, rng: np.random.Generator, joints: int) -> None:
        self._rng, self._joints = rng, joints
        self._std: Float64 = np.array([ENCODER_STD_RAD, _SECOND_SENSOR_STD_RAD, _SPEED_STD_RAD_S])
        self.clean = np.zeros((2, joints))
        """Sign and zero error of sensors without a fault, (2, J)."""
        self.clean[SIGN] = 1.0
        self._rows = self._drawn()

    def now(self, tick: int) -> Float64:
        """Noise of a tick, (3, J)."""
        return self._rows[tick % _NOISE_ROWS]

    def advance(self, tick: int) -> None:
        """Draw the next batch when this one is used up."""
        if tick % _NOISE_ROWS == 0:
            self._rows = self._drawn()

    def _drawn(self) -> Float64:
        rows: Float64 = self._rng.standard_normal((_NOISE_ROWS, 3, self._joints)) * self._std[:, None]
        return rows
