"""The simulated exoskeleton on a virtual patient's hand: a HandRobot whose physics is MuJoCo."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from robot_iface.kinematics import patient_hand
from robot_iface.sim.effort import PatientEffort, patient_spasms, spasm_rows
from robot_iface.sim.engine import mujoco
from robot_iface.sim.faults import Fault, FaultInjector
from robot_iface.sim.kernels import push, sense
from robot_iface.sim.kinds import VirtualPatient, patient_of
from robot_iface.sim.model import DRIVEN, PERIOD_S, ROTOR_INERTIA_KG_M2, build_model, hand_landmarks
from robot_iface.sim.motors import ENCODER_STD_RAD, MOTOR_CAP_NM, Motors, SensorNoise
from robot_iface.sim.straps import seated_rad, strap_rows
from robot_iface.types import Capabilities, DeviceCommand, DeviceState, Float64, Int64, PatientTwin

PERIOD_NS = round(PERIOD_S * 1e9)
_WARM_TICKS = 100
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
        tau_max_nm=np.full(len(DRIVEN), MOTOR_CAP_NM),
        worn=True,
        unpowered="free",
        encoder_std_rad=ENCODER_STD_RAD,
        inertia_kg_m2=ROTOR_INERTIA_KG_M2,
    )


class SimulatedExoskeleton:
    """An exoskeleton that drives 12 joints of a simulated hand.

    Physics advances only by ``advance`` (one period), so that its time is whatever the clock makes it.

    Args:
        twin: Whose hand is inside, and how the device sits on it.
        seed: Seed of sensor noise, tremor and clonus.
        faults: Faults to plant.
        patient: The patient's parameters; by default those of the twin's kind and measured stiffness.

    Raises:
        Refused: The kind of patient does not exist, the hand is no hand, or the device cannot sit on it so.
    """

    def __init__(
        self,
        twin: PatientTwin,
        seed: int,
        faults: Iterable[Fault] = (),
        patient: VirtualPatient | None = None,
    ) -> None:
        rng = np.random.default_rng(seed)
        who = patient or patient_of(twin)
        self._capabilities = device_capabilities()
        low, high = self._capabilities.q_min_rad, self._capabilities.q_max_rad
        geometry = patient_hand(twin)
        self._straps = strap_rows(twin, geometry, DRIVEN, low, high)
        self._hand = build_model(geometry, who, low, high)
        self._model: Any = self._hand.model
        self._data: Any = mujoco.MjData(self._model)
        self._qpos: Float64 = self._data.qpos
        self._qvel: Float64 = self._data.qvel
        self._force: Float64 = self._data.qfrc_applied
        self._lengths: Float64 = self._model.tendon_lengthspring
        self._places: Int64 = np.array([self._hand.robot, self._hand.worn])
        self._motors = Motors(self._model, self._hand.robot)
        self._noise = SensorNoise(rng, len(DRIVEN))
        self._sensors = self._noise.clean.copy()
        self._faults = FaultInjector(faults, DRIVEN)
        self._faults.turn_sensors(0.0, self._sensors)
        self._seat()
        rest = self._qpos[self._hand.worn].copy()
        self.patient = PatientEffort(who, rest, rng, self._all_spasms(twin))
        self._tau_nm = np.zeros(len(DRIVEN))
        self._ticks = 0
        self._t_ns = 0
        self._compile()

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

    @property
    def landmarks_m(self) -> Float64:
        """True digit landmarks in the palm frame, by the engine's own kinematics, LANDMARKS[:20], (20, 3)."""
        return hand_landmarks(self._hand, self.hand_rad)

    def open(self) -> None:
        """Connect; the motors stay unpowered."""
        self.power_off()

    def read(self) -> DeviceState:
        """The state after the last period, with sensor noise.

        Raises:
            OSError: A fault of the line is planted.
        """
        t_s = self._ticks * PERIOD_S
        self._faults.check_line("read-error", t_s)
        q, second, speed, interaction = self._sensed()
        state = DeviceState(
            self._t_ns,
            self._ticks,
            q,
            second,
            speed,
            self._tau_nm.copy(),
            interaction,
            self._motors.temperature_c,
            (),
        )
        return self._faults.reading(state, t_s)

    def write(self, command: DeviceCommand) -> None:
        """Apply a command from now on; without power it has no effect.

        Raises:
            OSError: A fault of the line is planted.
        """
        self._faults.check_line("write-error", self._ticks * PERIOD_S)
        self._motors.obey(command)

    def enable(self) -> None:
        """Power the motors; they do nothing until the first command."""
        self._motors.enable()

    def brake(self, damping_nms_rad: float) -> None:
        """Short the motors through a resistance: damping without a goal, inside the physics and so stable."""
        self._motors.brake(damping_nms_rad)

    def power_off(self) -> None:
        """Cut motor power and release the brake: the joints are free."""
        self._motors.power_off()

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
        self._push(self.patient.pull(self._qpos, self._qvel, self._places[1]))
        mujoco.mj_step(self._model, self._data)
        self._ticks += 1
        self._t_ns = self._t_ns + PERIOD_NS if t_ns is None else t_ns
        self._faults.turn_sensors(self._ticks * PERIOD_S, self._sensors)
        self._noise.advance(self._ticks)
        if self._ticks % _WARM_TICKS == 0:
            self._motors.warm(self._tau_nm, _WARM_TICKS * PERIOD_S)

    def _push(self, muscles_nm: Float64) -> None:
        push(
            self._qpos,
            self._qvel,
            self._places,
            self._motors.told,
            self._sensors,
            self._straps,
            self._ticks * PERIOD_S,
            MOTOR_CAP_NM,
            muscles_nm,
            self._tau_nm,
            self._force,
            self._lengths,
        )

    def _sensed(self) -> Float64:
        read = np.empty((4, len(DRIVEN)))
        t_s, noise = self._ticks * PERIOD_S, self._noise.now(self._ticks)
        sense(self._qpos, self._qvel, self._places, self._straps, t_s, self._sensors, noise, read)
        return read

    def _compile(self) -> None:
        """Have the machine code ready before the first tick; every tick overwrites what these calls set."""
        self._push(np.zeros(len(DRIVEN)))
        self._sensed()

    def _seat(self) -> None:
        """The hand at rest, every link where its strap is not strained."""
        hand = self._hand
        self._qpos[hand.hand] = hand.rest_rad
        self._qpos[hand.robot] = seated_rad(self._straps, self._qpos[hand.worn])

    def _all_spasms(self, twin: PatientTwin) -> Float64:
        planted = spasm_rows(self._faults.spasms, DRIVEN, np.ones(len(DRIVEN)))
        return np.vstack([patient_spasms(twin.spasms), planted])
