"""MuJoCo tree of the DLR-HIT-Hand II: the chains of ``robot_iface.kinematics`` with masses and surfaces.

Thicknesses are the thesis's (Table 5.2), masses the hand's public description's; the rotor inertia is
assumed, as that for which the thesis's gains are critically damped. The hand carries its own fingers'
weight (``gravcomp``), as its controller's gravity term does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robot_iface.kinematics.dlr_hit import (
    DH_ROWS,
    FINGER_MAX_RAD,
    FINGER_MIN_RAD,
    LINKS_M,
    DlrHitHand,
    dlr_hit_hand,
)
from robot_iface.sim.engine import mujoco
from robot_iface.types import DIGITS, Float64, Int64

PALM_HALF_M = 0.031
"""Half of the palm's thickness: its surface lies so far palmar of the knuckles' plane, m."""
LINK_HALF_M = (0.0175, 0.013, 0.012)
"""Half thickness of proximal, medial and distal link (Table 5.2), m."""
LINK_MASS_KG = (0.0444, 0.0271, 0.0182)
ROTOR_INERTIA_KG_M2 = 3e-4
LINKS = ("proximal", "medial", "distal")
HAND_BIT, OBJECT_BIT = 1, 2
"""Collision bits: links and palm meet objects, never one another."""

# The palm's plate covers the wrist to the knuckles; its surface is the plane that the grasp measures from.
_PALM_CENTRE_M = (0.0, -0.003, 0.061)
_PALM_SIZE_M = (PALM_HALF_M, 0.058, 0.051)
_PALM_MASS_KG = 1.05  # the hand weighs 1.5 kg with its five fingers
_JOINTS = ("abduction", "mcp", "pip")
_COUPLING_SOLREF = (0.002, 1.0)
_COUPLING_SOLIMP = (0.999, 0.9999, 0.001, 0.5, 2.0)


@dataclass(frozen=True, slots=True)
class DlrHitAddresses:
    """Where the hand's parts stand in the arrays of a compiled model.

    Attributes:
        qpos: Address of abduction, MCP and PIP of each digit (thumb first) in ``qpos``, shape (5, 3).
        dof: The same in ``qvel``, shape (5, 3).
        dip_qpos: Address of the distal joints in ``qpos``, shape (5,).
        sites: First joint, PIP, DIP and tip of each digit among the sites, shape (5, 4).
        bodies: Proximal, medial and distal link among the bodies, shape (5, 3).
        palm: The palm among the bodies.
    """

    qpos: Int64
    dof: Int64
    dip_qpos: Int64
    sites: Int64
    bodies: Int64
    palm: int


def add_dlr_hit(
    spec: Any, parent: Any, hand: DlrHitHand, pos_m: Float64, quat_wxyz: Float64, friction: float
) -> None:
    """The hand as a subtree of a model that is being built.

    Args:
        spec: The ``mujoco.MjSpec``, its angles in radians.
        parent: The body that carries the palm.
        hand: Where its fingers stand.
        pos_m: The wrist (CMC), origin of the palm frame, in the parent's frame, shape (3,).
        quat_wxyz: Orientation of the palm frame in the parent's, shape (4,).
        friction: Sliding friction of palm and links.
    """
    palm = parent.add_body(name="palm", pos=pos_m, quat=quat_wxyz, gravcomp=1.0)
    palm.add_geom(
        name="palm",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=_PALM_CENTRE_M,
        size=_PALM_SIZE_M,
        mass=_PALM_MASS_KG,
        **_surface(friction),
    )
    for digit, name in enumerate(DIGITS):
        _add_finger(spec, palm, name, hand.bases_m[digit], hand.base_rotation[digit], friction)


def addresses(model: Any) -> DlrHitAddresses:
    """Where a compiled model holds its one DLR-HIT-Hand II."""
    joints = [[model.joint(f"{digit}_{joint}") for joint in _JOINTS] for digit in DIGITS]
    return DlrHitAddresses(
        qpos=np.array([[joint.qposadr[0] for joint in row] for row in joints]),
        dof=np.array([[joint.dofadr[0] for joint in row] for row in joints]),
        dip_qpos=np.array([model.joint(f"{digit}_dip").qposadr[0] for digit in DIGITS]),
        sites=np.array([[model.site(f"{digit}_{at}").id for at in range(4)] for digit in DIGITS]),
        bodies=np.array([[model.body(f"{digit}_{link}").id for link in LINKS] for digit in DIGITS]),
        palm=int(model.body("palm").id),
    )


def simulated_points(joints_rad: Float64) -> Float64:
    """Joints and fingertips by MuJoCo's own kinematics, in the palm frame.

    Args:
        joints_rad: Abduction, MCP and PIP of the five digits, shape (5, 3); DIP = PIP.

    Returns:
        First joint, PIP, DIP and tip of each digit, shape (5, 4, 3), m.
    """
    spec: Any = mujoco.MjSpec()
    spec.compiler.degree = False
    add_dlr_hit(spec, spec.worldbody, dlr_hit_hand(), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), 1.0)
    model: Any = spec.compile()
    at, state = addresses(model), mujoco.MjData(model)
    state.qpos[at.qpos] = joints_rad
    state.qpos[at.dip_qpos] = joints_rad[:, 2]
    mujoco.mj_kinematics(model, state)
    points: Float64 = state.site_xpos[at.sites].copy()
    return points


def _add_finger(spec: Any, palm: Any, name: str, base_m: Float64, rotation: Float64, friction: float) -> None:
    frames = [_row(row) for row in range(len(DH_ROWS))]
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = rotation, base_m
    # abduction and MCP cross in one point: one body with two joints stands at the MCP's frame
    poses = [base @ frames[0] @ frames[1], frames[2], frames[3]]
    ends = [frames[2][:3, 3], frames[3][:3, 3], frames[4][:3, 3]]
    parent = palm
    for link, (pose, end) in enumerate(zip(poses, ends, strict=True)):
        body = parent.add_body(
            name=f"{name}_{LINKS[link]}", pos=pose[:3, 3], quat=_quaternion(pose[:3, :3]), gravcomp=1.0
        )
        if link == 0:
            across = frames[1][:3, :3].T @ np.array([0.0, 0.0, 1.0])
            _add_joint(body, f"{name}_abduction", across, 0)
        _add_joint(body, f"{name}_{('mcp', 'pip', 'dip')[link]}", np.array([0.0, 0.0, 1.0]), min(link, 1) + 1)
        body.add_site(name=f"{name}_{link}")
        _add_link(body, end, link, friction)
        parent = body
    parent.add_site(name=f"{name}_3", pos=ends[2])
    spec.add_equality(
        name=f"{name}_coupling",
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=f"{name}_dip",
        name2=f"{name}_pip",
        data=[0.0, 1.0, *[0.0] * 10],
        solref=_COUPLING_SOLREF,
        solimp=_COUPLING_SOLIMP,
    )


def _add_joint(body: Any, name: str, axis: Float64, column: int) -> None:
    # the rotors of a finger are three: the distal joint hangs on the middle one's
    driven = not name.endswith("_dip")
    body.add_joint(
        name=name,
        axis=axis,
        armature=ROTOR_INERTIA_KG_M2 if driven else 1e-6,
        limited=mujoco.mjtLimited.mjLIMITED_TRUE,
        range=[FINGER_MIN_RAD[column], FINGER_MAX_RAD[column]],
    )


def _add_link(body: Any, end_m: Float64, link: int, friction: float) -> None:
    along = end_m / LINKS_M[link]
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=[0.0, 0.0, 0.0, *(along * LINKS_M[link])],
        size=[LINK_HALF_M[link], 0.0, 0.0],
        mass=LINK_MASS_KG[link],
        **_surface(friction),
    )


def _surface(friction: float) -> dict[str, Any]:
    return {"friction": [friction, 0.005, 1e-4], "contype": HAND_BIT, "conaffinity": OBJECT_BIT, "condim": 4}


def _row(row: int) -> Float64:
    """Rx(alpha) Tx(a) Rz(offset) Tz(d) of a row at joint angle zero, shape (4, 4)."""
    alpha, a, offset, d = (float(value) for value in DH_ROWS[row])
    ca, sa, co, so = np.cos(alpha), np.sin(alpha), np.cos(offset), np.sin(offset)
    return np.array(
        [
            [co, -so, 0.0, a],
            [ca * so, ca * co, -sa, -sa * d],
            [sa * so, sa * co, ca, ca * d],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def _quaternion(rotation: Float64) -> Float64:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
