"""Reach and grasp (thesis 5.2): the arm brings the hand, the fingers close, the table goes: does it hold?

Deterministic: no randomness anywhere. The posture comes in as joint angles; the fingers are not placed at
them but driven towards them by the thesis's PD law within the motors' torque, so that an object in the way
stops them and the rest of the way is what they press with.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robot_iface.errors import Refused
from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD
from robot_iface.sim.engine import mujoco
from robot_iface.sim.reach_arm import (
    END_M,
    GRASP_S,
    REACH_S,
    START_M,
    TRIAL_S,
    arm_torque_nm,
    cubic,
    quintic,
)
from robot_iface.sim.reach_world import PERIOD_S, FreeCylinder, ReachWorld, build_world, start_state
from robot_iface.types import DIGITS, Float64

STIFFNESS_NM_RAD: Float64 = np.array([0.3, 0.3, 0.4])
DAMPING_NMS_RAD: Float64 = np.array([0.02, 0.02, 0.027])
"""The thesis's gains of MCP and PIP; it gives none for abduction, which takes the MCP's."""
TORQUE_CAP_NM: Float64 = np.array([1.05, 1.05, 0.5])
"""What gives 10 N at the tip of a straight finger, the real hand's figure."""
SQUEEZE_RAD = 0.3
"""How far beyond the contact posture the long fingers are ordered: touching alone presses on nothing."""
PUSH_N = 0.5
HOLD_S = 1.0
HOLD_M = 0.005
_RECORD_EVERY = 10


@dataclass(frozen=True, slots=True)
class ReachRecord:
    """Trajectories of a trial, one row every 10 ms (Figure 5.12); Cartesian ones in the MIT-Manus frame.

    Attributes:
        t_s: Time, shape (T,).
        joints_rad: Abduction, MCP, PIP and DIP of the five digits, thumb first, shape (T, 5, 4).
        reference_rad: Where abduction, MCP and PIP should be, shape (T, 5, 3).
        points_m: First joint, PIP, DIP and tip of each digit, shape (T, 5, 4, 3).
        arm_rad: Shoulder, elbow and the levelled wrist, shape (T, 3).
        end_m: The arm's end, shape (T, 2).
        end_reference_m: Where it should be, shape (T, 2).
        object_m: The cylinder's middle, shape (T, 3).
    """

    t_s: Float64
    joints_rad: Float64
    reference_rad: Float64
    points_m: Float64
    arm_rad: Float64
    end_m: Float64
    end_reference_m: Float64
    object_m: Float64


@dataclass(frozen=True, slots=True)
class Held:
    """What a second without the table did to the object.

    Attributes:
        push_n: The push at its middle, in the MIT-Manus frame, shape (3,).
        moved_m: How far its middle went at most.
        turned_rad: How far it turned at the end.
        holds: Whether it went less than 5 mm.
    """

    push_n: Float64
    moved_m: float
    turned_rad: float
    holds: bool


@dataclass(frozen=True, slots=True)
class Grasp:
    """A trial and what became of the object.

    Attributes:
        cylinder: The object.
        target_rad: What the digits were driven to: the posture and its squeeze, shape (5, 3).
        record: The trajectories.
        link_force_n: Normal force on proximal, medial and distal link at the end of the trial, shape (5, 3).
        palm_force_n: Normal force on the palm then.
        held: Without the table: by gravity alone first, then with every push.
    """

    cylinder: FreeCylinder
    target_rad: Float64
    record: ReachRecord
    link_force_n: Float64
    palm_force_n: float
    held: tuple[Held, ...]

    @property
    def holds(self) -> bool:
        """Whether it holds against gravity and every push."""
        return all(one.holds for one in self.held)


def reach_and_grasp(
    posture_rad: Float64,
    cylinder: FreeCylinder,
    squeeze_rad: float = SQUEEZE_RAD,
    pushes_n: Float64 | None = None,
) -> Grasp:
    """One trial of section 5.2.3, then a second without the table under every push.

    Args:
        posture_rad: Abduction, MCP and PIP of the five digits around the object, thumb first, shape (5, 3).
        cylinder: The object.
        squeeze_rad: How much farther MCP and PIP of the four long fingers are ordered, within their range.
        pushes_n: Pushes at the object's middle in the MIT-Manus frame, shape (P, 3); by default 0.5 N along
            and against every axis.

    Raises:
        Refused: The posture has another shape, is not finite or leaves the hand's range, or the squeeze is
            not between 0 and 1 rad.
    """
    target = _squeezed(_checked(posture_rad), squeeze_rad)
    pushes = PUSH_N * np.concatenate([np.eye(3), -np.eye(3)]) if pushes_n is None else pushes_n
    world = build_world(cylinder)
    trial = _Trial(world, target)
    record = trial.run()
    link_force, palm_force = trial.forces_n()
    world.model.geom_conaffinity[world.table_geom] = 0  # the table is taken away
    world.model.geom_contype[world.table_geom] = 0
    held = tuple(trial.hold(push) for push in np.concatenate([np.zeros((1, 3)), pushes]))
    return Grasp(cylinder, target, record, link_force, palm_force, held)


def finger_torque_nm(
    joints_rad: Float64, joints_rad_s: Float64, reference_rad: Float64, reference_rad_s: Float64
) -> Float64:
    """The thesis's joint PD law within the motors' torque.

    Args:
        joints_rad: Abduction, MCP and PIP, shape (..., 3).
        joints_rad_s: Their speeds, shape (..., 3).
        reference_rad: Where they should be, shape (..., 3).
        reference_rad_s: How fast they should turn, shape (..., 3).

    Returns:
        Torques, shape (..., 3), Nm.
    """
    tau = STIFFNESS_NM_RAD * (reference_rad - joints_rad)
    tau += DAMPING_NMS_RAD * (reference_rad_s - joints_rad_s)
    return np.clip(tau, -TORQUE_CAP_NM, TORQUE_CAP_NM)


class _Trial:
    """One scene and its controllers."""

    def __init__(self, world: ReachWorld, target_rad: Float64) -> None:
        self._world = world
        self._target_rad = target_rad
        self._state: Any = start_state(world)
        self._step = 0

    def run(self) -> ReachRecord:
        """The whole trial from its start, 5 s."""
        rows: list[tuple[Float64, ...]] = []
        for step in range(round(TRIAL_S / PERIOD_S) + 1):
            references = self._drive(self._state, step * PERIOD_S)
            if step % _RECORD_EVERY == 0:
                rows.append(self._row(step * PERIOD_S, references))
            mujoco.mj_step(self._world.model, self._state)
        return ReachRecord(*(np.array(column) for column in zip(*rows, strict=True)))

    def hold(self, push_n: Float64) -> Held:
        """A second from the end of the trial on, under a push; the trial's own state stays as it is."""
        model, cylinder = self._world.model, self._world.cylinder
        state: Any = mujoco.MjData(model)
        mujoco.mj_copyData(state, model, self._state)
        state.xfrc_applied[cylinder, :3] = push_n
        first, heading = state.xpos[cylinder].copy(), state.xquat[cylinder].copy()
        moved = 0.0
        for _ in range(round(HOLD_S / PERIOD_S)):
            self._drive(state, TRIAL_S)
            mujoco.mj_step(model, state)
            moved = max(moved, float(np.linalg.norm(state.xpos[cylinder] - first)))
        turned = 2.0 * float(np.arccos(min(1.0, abs(float(heading @ state.xquat[cylinder])))))
        return Held(np.asarray(push_n, dtype=np.float64), moved, turned, moved < HOLD_M)

    def forces_n(self) -> tuple[Float64, float]:
        """Normal forces between the object and every link, shape (5, 3), and the palm."""
        model, hand = self._world.model, self._world.hand
        links, palm = np.zeros((len(DIGITS), 3)), 0.0
        wrench = np.zeros(6)
        for index in range(self._state.ncon):
            contact = self._state.contact[index]
            if self._world.cylinder_geom not in contact.geom:
                continue
            mujoco.mj_contactForce(model, self._state, index, wrench)
            bodies = model.geom_bodyid[contact.geom]
            links[np.isin(hand.bodies, bodies)] += wrench[0]
            palm += float(wrench[0]) if hand.palm in bodies else 0.0
        return links, palm

    def _drive(self, state: Any, t_s: float) -> tuple[Float64, Float64]:
        """Torques of a tick; returns where fingers and arm should be."""
        share, rate = quintic(t_s, REACH_S)
        end_reference = START_M + share * (END_M - START_M)
        arm = self._world.arm
        torque, _ = arm_torque_nm(
            state.qpos[arm[:2]], state.qvel[arm[:2]], end_reference, rate * (END_M - START_M)
        )
        state.qfrc_applied[arm[:2]] = torque
        share, rate = cubic(t_s - REACH_S, GRASP_S)
        hand, reference = self._world.hand, share * self._target_rad
        state.qfrc_applied[hand.dof] = finger_torque_nm(
            state.qpos[hand.qpos], state.qvel[hand.dof], reference, rate * self._target_rad
        )
        return reference, end_reference

    def _row(self, t_s: float, references: tuple[Float64, Float64]) -> tuple[Float64, ...]:
        world, state = self._world, self._state
        mujoco.mj_kinematics(world.model, state)
        hand = world.hand
        joints = np.concatenate([state.qpos[hand.qpos], state.qpos[hand.dip_qpos][:, None]], axis=1)
        arm = state.qpos[world.arm].copy()
        _, end = arm_torque_nm(arm[:2], np.zeros(2), np.zeros(2), np.zeros(2))
        cylinder = state.xpos[world.cylinder].copy()
        points = state.site_xpos[hand.sites].copy()
        return np.array(t_s), joints, references[0], points, arm, end, references[1], cylinder


def _checked(target_rad: Float64) -> Float64:
    target = np.array(target_rad, dtype=np.float64)
    if target.shape != (len(DIGITS), 3):
        raise Refused(
            "posture shape", str(target.shape), "(5, 3)", "give abduction, MCP and PIP of five digits"
        )
    if not bool(np.isfinite(target).all()):
        raise Refused("posture", "not finite", "angles in radians", "give finite angles")
    outside = np.maximum(FINGER_MIN_RAD - target, target - FINGER_MAX_RAD)
    if bool((outside > 1e-9).any()):
        digit, joint = np.unravel_index(int(np.argmax(outside)), outside.shape)
        name = ("abduction", "MCP", "PIP")[int(joint)]
        raise Refused(
            f"{DIGITS[int(digit)]} {name}",
            f"{float(target[digit, joint]):.4g} rad",
            f"{float(FINGER_MIN_RAD[joint]):.4g} to {float(FINGER_MAX_RAD[joint]):.4g} rad",
            "choose another posture",
        )
    return target


def _squeezed(posture_rad: Float64, squeeze_rad: float) -> Float64:
    if not 0.0 <= squeeze_rad <= 1.0:
        raise Refused("squeeze", f"{squeeze_rad:g} rad", "0 to 1 rad", "choose another squeeze")
    target = posture_rad.copy()
    target[1:, 1:] = np.minimum(target[1:, 1:] + squeeze_rad, FINGER_MAX_RAD[1:])
    return target
