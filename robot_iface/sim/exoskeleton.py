"""The simulated exoskeleton on a virtual patient's hand: a HandRobot whose physics is MuJoCo."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from robot_iface.kinematics import average_hand
from robot_iface.sim.effort import PatientEffort
from robot_iface.sim.engine import mujoco
from robot_iface.sim.faults import Fault, FaultInjector
from robot_iface.sim.kinds import VirtualPatient, virtual_patient
from robot_iface.sim.model import (
    DRIVEN,
    PERIOD_S,
    STRAP_DAMPING_NMS_RAD,
    STRAP_STIFFNESS_NM_RAD,
    build_model,
)
from robot_iface.types import Capabilities, CommandMode, DeviceCommand, DeviceState, Float64, PatientTwin

PERIOD_NS = round(PERIOD_S * 1e9)
_ENCODER_STD_RAD = 2e-4
_SECOND_SENSOR_STD_RAD = 1e-3
_SPEED_STD_RAD_S = 2e-3
_MOTOR_CAP_NM = 0.6
_NOISE_ROWS = 1024
_HEATING_K_PER_NM2_S = 0.9  # copper losses warm the hottest motor ...
_COOLING_PER_S = 0.02  # ... and air cools it
_AMBIENT_C = 25.0
_RANGE_DEG: dict[str, tuple[float, float]] = {
    "thumb_cmc_flexion": (-20.0, 40.0),
    "thumb_cmc_abduction": (-25.0, 40.0),
    "thumb_mcp_flexion": (-5.0, 60.0),
    "thumb_ip": (-10.0, 80.0),
    "mcp_flexion": (-15.0, 90.0),
    "pip": (-5.0, 105.0),
}


def device_capabilities() -> Capabilities:
    """What the simulated exoskeleton is and can do, known without building one."""
    ranges = [_RANGE_DEG.get(name) or _RANGE_DEG[name.split("_", 1)[1]] for name in DRIVEN]
    q_min, q_max = np.deg2rad(np.array(ranges)).T
    return Capabilities(
        name="exoskeleton",
        simulated=True,
        joint_names=DRIVEN,
        period_ns=PERIOD_NS,
        q_min_rad=q_min,
        q_max_rad=q_max,
        tau_max_nm=np.full(len(DRIVEN), _MOTOR_CAP_NM),
        worn=True,
        unpowered="free",
        encoder_std_rad=_ENCODER_STD_RAD,
    )


class SimulatedExoskeleton:
    """An exoskeleton that drives 12 joints of a simulated hand.

    Physics advances only by ``advance`` (one period), so that its time is whatever the clock makes it.

    Args:
        twin: Whose hand is inside.
        seed: Seed of sensor noise and tremor.
        faults: Faults to plant.
        patient: The patient's parameters; by default those of the twin's kind.

    Raises:
        Refused: The kind of patient or the hand's length does not exist.
    """

    def __init__(
        self,
        twin: PatientTwin,
        seed: int,
        faults: Iterable[Fault] = (),
        patient: VirtualPatient | None = None,
    ) -> None:
        rng = np.random.default_rng(seed)
        who = patient or virtual_patient(twin.kind)
        self._capabilities = device_capabilities()
        geometry = average_hand(twin.hand_length_m, twin.side)
        self._hand = build_model(geometry, who, self._capabilities.q_min_rad, self._capabilities.q_max_rad)
        self._model: Any = self._hand.model
        self._data: Any = mujoco.MjData(self._model)
        self._qpos: Float64 = self._data.qpos
        self._qvel: Float64 = self._data.qvel
        self._force: Float64 = self._data.qfrc_applied
        self._qpos[self._hand.hand] = self._hand.rest_rad
        self._qpos[self._hand.robot] = self._qpos[self._hand.worn]
        self._rotor_damping: Float64 = self._model.dof_damping[self._hand.robot].copy()
        self.patient = PatientEffort(who, self._qpos[self._hand.worn].copy(), rng)
        self._faults = FaultInjector(faults)
        self._rng = rng
        self._noise = _noise(rng)
        self._command: DeviceCommand | None = None
        self._powered = False
        self._tau_nm = np.zeros(len(DRIVEN))
        self._temperature_c = _AMBIENT_C
        self._ticks = 0
        self._t_ns = 0

    @property
    def capabilities(self) -> Capabilities:
        """What the device is and can do."""
        return self._capabilities

    @property
    def hand_rad(self) -> Float64:
        """True angles of the patient's 21 joints, in the order of JOINTS, (21,); not a sensor."""
        return self._qpos[self._hand.hand].copy()

    @property
    def hand_speed_rad_s(self) -> Float64:
        """True speeds of the patient's 21 joints, (21,); not a sensor."""
        return self._qvel[self._hand.hand].copy()

    def open(self) -> None:
        """Connect; the motors stay unpowered."""
        self.power_off()

    def read(self) -> DeviceState:
        """The state after the last period, with sensor noise."""
        hand, noise = self._hand, self._noise[self._ticks % _NOISE_ROWS]
        q, dq = self._qpos[hand.robot], self._qvel[hand.robot]
        stretch, rate = q - self._qpos[hand.worn], dq - self._qvel[hand.worn]
        state = DeviceState(
            t_ns=self._t_ns,
            seq=self._ticks,
            q_rad=q + noise[0],
            q_second_rad=q + noise[1],
            dq_rad_s=dq + noise[2],
            tau_nm=self._tau_nm,
            tau_interaction_nm=STRAP_STIFFNESS_NM_RAD * stretch + STRAP_DAMPING_NMS_RAD * rate,
            temperature_c=self._temperature_c,
            faults=(),
        )
        return self._faults.reading(state, self._ticks * PERIOD_S)

    def write(self, command: DeviceCommand) -> None:
        """Apply a command from now on; without power it has no effect."""
        if self._command is None:
            self._model.dof_damping[self._hand.robot] = self._rotor_damping
        self._command = command

    def enable(self) -> None:
        """Power the motors; they do nothing until the first command."""
        self._powered = True

    def brake(self, damping_nms_rad: float) -> None:
        """Short the motors through a resistance: damping without a goal, inside the physics and so stable."""
        self._command = None
        self._model.dof_damping[self._hand.robot] = self._rotor_damping + damping_nms_rad

    def power_off(self) -> None:
        """Cut motor power and release the brake: the joints are free."""
        self._powered = False
        self._command = None
        self._model.dof_damping[self._hand.robot] = self._rotor_damping

    def clear_faults(self) -> None:
        """Clear device faults; a planted fault comes back while its cause lasts."""

    def close(self) -> None:
        """Disconnect; power is cut first."""
        self.power_off()

    def advance(self, t_ns: int | None = None) -> None:
        """One period of physics under the last command.

        Args:
            t_ns: Time to stamp it with on the loop's clock; by default one period after the last.
        """
        hand = self._hand
        q, dq = self._qpos[hand.robot], self._qvel[hand.robot]
        self._tau_nm = self._motor_nm(q, dq)
        self._force[hand.robot] = self._tau_nm
        self._force[hand.worn] = 0.0
        muscles = self.patient.torque_nm(self._qpos[hand.worn], self._qvel[hand.worn])
        if muscles is not None:
            self._force[hand.worn] = muscles
        spasm = self._faults.torque_nm(self._ticks * PERIOD_S)
        if spasm is not None:
            self._force[hand.worn] += spasm
        mujoco.mj_step(self._model, self._data)
        self._ticks += 1
        self._t_ns = self._t_ns + PERIOD_NS if t_ns is None else t_ns
        if self._ticks % _NOISE_ROWS == 0:
            self._noise = _noise(self._rng)
        if self._ticks % 100 == 0:
            self._warm(0.1)

    def _motor_nm(self, q_rad: Float64, dq_rad_s: Float64) -> Float64:
        """The device's own impedance loop, within its motors' cap."""
        command = self._command
        if command is None or not self._powered:
            return np.zeros(len(DRIVEN))
        tau = command.tau_ff_nm
        if command.mode == CommandMode.IMPEDANCE:
            tau = (
                tau
                + command.stiffness_nm_rad * (command.q_rad - q_rad)
                + command.damping_nms_rad * (command.dq_rad_s - dq_rad_s)
            )
        return np.minimum(np.maximum(tau, -_MOTOR_CAP_NM), _MOTOR_CAP_NM)

    def _warm(self, seconds: float) -> None:
        loss = _HEATING_K_PER_NM2_S * float(np.abs(self._tau_nm).max()) ** 2
        self._temperature_c += seconds * (loss - _COOLING_PER_S * (self._temperature_c - _AMBIENT_C))


def _noise(rng: np.random.Generator) -> Float64:
    """Sensor noise of the next rows: first sensor, second sensor, speed, (rows, 3, 12)."""
    std = np.array([_ENCODER_STD_RAD, _SECOND_SENSOR_STD_RAD, _SPEED_STD_RAD_S])
    return rng.standard_normal((_NOISE_ROWS, 3, len(DRIVEN))) * std[:, None]
