"""The simulated DLR-HIT-Hand II as a HandRobot: it is not worn and follows a retargeted reference."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, dlr_hit_hand
from robot_iface.sim.dlr_hit import ROTOR_INERTIA_KG_M2, add_dlr_hit, addresses
from robot_iface.sim.effort import Nobody, spasm_rows
from robot_iface.sim.engine import mujoco
from robot_iface.sim.faults import Fault, FaultInjector
from robot_iface.sim.kernels import motor_torque, sense_bare
from robot_iface.sim.motors import ENCODER_STD_RAD, MOTOR_CAP_NM, Motors, SensorNoise
from robot_iface.sim.muscles import PERIOD_S, spasm_torque
from robot_iface.types import FINGERS, Capabilities, DeviceCommand, DeviceState, Float64, Int64, Spasm

DLR_HIT_JOINTS: tuple[str, ...] = (
    *("thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip"),
    *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_abduction", "mcp_flexion", "pip")),
)
"""The 15 joints that it drives, by the name of the human joint in whose place they stand: abduction, MCP and
PIP of every digit, the thumb first; its distal joints follow, one to one."""
PERIOD_NS = round(PERIOD_S * 1e9)
_WARM_TICKS = 100
_START_RAD: Float64 = np.tile(np.deg2rad([0.0, 10.0, 10.0]), 5)  # nearly straight, clear of the stops
_GEAR_DAMPING_NMS_RAD = 0.02  # of harmonic drives that nobody compensates (assumed: the thesis's own D)
_FRICTION = 0.6


def dlr_hit_capabilities() -> Capabilities:
    """What the simulated DLR-HIT-Hand II is and can do, known without building one.

    Ranges are the thesis's (Table 5.2). Without power its joints are damped: harmonic drives turn backwards,
    but against the friction of their gears, and the controller that compensates it is off.
    """
    return Capabilities(
        name="dlr-hit-ii",
        simulated=True,
        joint_names=DLR_HIT_JOINTS,
        period_ns=PERIOD_NS,
        q_min_rad=np.tile(FINGER_MIN_RAD, 5),
        q_max_rad=np.tile(FINGER_MAX_RAD, 5),
        tau_max_nm=np.full(len(DLR_HIT_JOINTS), MOTOR_CAP_NM),
        worn=False,
        unpowered="damped",
        encoder_std_rad=ENCODER_STD_RAD,
        chain="dlr-hit-ii",
        inertia_kg_m2=ROTOR_INERTIA_KG_M2,
    )


class SimulatedDlrHit:
    """The robot hand on its own: five fingers, no arm, no object.

    Gravity acts and is compensated, as by the hand's own controller. Nothing touches the hand, so its torque
    sensors feel nothing but the pushes that are planted (``pushes``, and faults of the kind spasm).

    Args:
        seed: Seed of sensor noise.
        faults: Faults to plant.
        pushes: Torques from outside at their times.

    Raises:
        Refused: A fault or a push names a joint that it does not have.
    """

    def __init__(self, seed: int, faults: Iterable[Fault] = (), pushes: tuple[Spasm, ...] = ()) -> None:
        spec: Any = mujoco.MjSpec()
        spec.compiler.degree = False  # the default reads radian limits as degrees
        spec.option.timestep = PERIOD_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        upright = np.array([1.0, 0.0, 0.0, 0.0])
        add_dlr_hit(spec, spec.worldbody, dlr_hit_hand(), np.zeros(3), upright, _FRICTION)
        self._model: Any = spec.compile()
        self._data: Any = mujoco.MjData(self._model)
        at = addresses(self._model)
        self._at: Int64 = np.ascontiguousarray(at.dof.ravel())
        self._qpos: Float64 = self._data.qpos
        self._qvel: Float64 = self._data.qvel
        self._force: Float64 = self._data.qfrc_applied
        self._qpos[at.qpos.ravel()] = _START_RAD
        self._qpos[at.dip_qpos] = _START_RAD[2::3]
        joints = len(DLR_HIT_JOINTS)
        self._motors = Motors(self._model, self._at, _GEAR_DAMPING_NMS_RAD)
        self._noise = SensorNoise(np.random.default_rng(seed), joints)
        self._sensors = self._noise.clean.copy()
        self._faults = FaultInjector(faults, DLR_HIT_JOINTS)
        self._faults.turn_sensors(0.0, self._sensors)
        self._pushes = spasm_rows((*pushes, *self._faults.spasms), DLR_HIT_JOINTS, np.ones(joints))
        self.patient = Nobody()
        self._tau_nm, self._pushed_nm = np.zeros(joints), np.zeros(joints)
        self._ticks = 0
        self._t_ns = 0
        # machine code is ready before the first tick; every tick overwrites what these calls set
        self._push()
        self._sensed()

    @property
    def capabilities(self) -> Capabilities:
        """What the device is and can do."""
        return dlr_hit_capabilities()

    @property
    def joints_rad(self) -> Float64:
        """True angles of the 15 driven joints, in the order of DLR_HIT_JOINTS, (15,); not a sensor."""
        return self._qpos[self._at].copy()

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
        warmth = self._motors.temperature_c
        state = DeviceState(
            self._t_ns, self._ticks, q, second, speed, self._tau_nm.copy(), interaction, warmth, ()
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
        """Cut motor power and release the brake: the gears still damp the joints."""
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
        self._push()
        mujoco.mj_step(self._model, self._data)
        self._ticks += 1
        self._t_ns = self._t_ns + PERIOD_NS if t_ns is None else t_ns
        self._faults.turn_sensors(self._ticks * PERIOD_S, self._sensors)
        self._noise.advance(self._ticks)
        if self._ticks % _WARM_TICKS == 0:
            self._motors.warm(self._tau_nm, _WARM_TICKS * PERIOD_S)

    def _push(self) -> None:
        told, at = self._motors.told, self._at
        motor_torque(self._qpos, self._qvel, at, told, self._sensors, MOTOR_CAP_NM, self._tau_nm)
        self._pushed_nm[:] = 0.0
        spasm_torque(self._ticks * PERIOD_S, self._pushes, self._pushed_nm)
        self._force[at] = self._tau_nm + self._pushed_nm

    def _sensed(self) -> Float64:
        read = np.empty((4, len(DLR_HIT_JOINTS)))
        noise = self._noise.now(self._ticks)
        sense_bare(self._qpos, self._qvel, self._at, self._pushed_nm, self._sensors, noise, read)
        return read
