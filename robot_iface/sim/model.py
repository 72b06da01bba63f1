"""MuJoCo model of a patient's hand inside an exoskeleton.

Two trees stand in one world whose frame is the palm. The hand is the kinematic chain of
``robot_iface.kinematics`` joint by joint. The exoskeleton has links and rotors of its own, laid along the
back of the digits; a spring-damper (a fixed tendon with coefficients +1 and -1: straps and soft tissue) joins
each driven joint to the patient's, and the force in it is the interaction torque. Axes that do not meet, and
straps that slip, change the rest lengths of the tendons (``robot_iface.sim.kernels``). Digits and palm have
skin and touch one another (``robot_iface.sim.skin``).

There is no gravity: the forearm rests mid-prone, so that fingers open and close in a horizontal plane, and an
orientation that nobody has measured would otherwise add a load that nobody has ordered.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robot_iface.kinematics import DIP_PER_PIP, HandGeometry
from robot_iface.sim.engine import mujoco
from robot_iface.sim.kernels import STRAP_DAMPING_NMS_RAD, STRAP_STIFFNESS_NM_RAD
from robot_iface.sim.kinds import VirtualPatient
from robot_iface.sim.muscles import PERIOD_S
from robot_iface.sim.skin import add_bone_skin, add_palm_skin, bone_radius_m, soften
from robot_iface.types import DIGITS, FINGERS, JOINTS, LANDMARKS, Float64, Int64

DRIVEN: tuple[str, ...] = (
    *("thumb_cmc_flexion", "thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip"),
    *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_flexion", "pip")),
)
"""The 12 joints that the exoskeleton drives."""

ROTOR_INERTIA_KG_M2 = 3e-4
_LINK_MASS_KG = 0.004
_LINK_DORSAL_M = 0.014  # exoskeleton links lie this far behind the bones
_STOP_BEYOND_RAD = float(np.deg2rad(3.0))  # mechanical stops stand this far outside the device's range
_TISSUE_INERTIA_KG_M2 = 2e-5  # soft tissue and tendons that move with a joint
_TISSUE_DENSITY_KG_M3 = 1100.0
_COUPLING_STIFFNESS_NM_RAD = 2.0
_COUPLING_DAMPING_NMS_RAD = 0.004
_UNDRIVEN_STIFFNESS_NM_RAD = 0.3

# Bones of a digit, each with the joints that turn it, the one nearest the palm first.
_THUMB_BONES: tuple[tuple[str, ...], ...] = (
    ("thumb_cmc_abduction", "thumb_cmc_flexion"),
    ("thumb_mcp_abduction", "thumb_mcp_flexion"),
    ("thumb_ip",),
)


@dataclass(frozen=True, slots=True)
class HandModel:
    """The compiled model and where its parts stand in MuJoCo's arrays.

    Attributes:
        model: The compiled ``mujoco.MjModel``.
        hand: Address in qpos and qvel of the 21 joints of the hand, in the order of JOINTS, (21,).
        robot: Address of the exoskeleton's joints, in the order of DRIVEN, (12,).
        worn: Address of the patient's joints that DRIVEN names, (12,). The straps are the model's first 12
            tendons, in the same order.
        rest_rad: The hand at rest, in the order of JOINTS, (21,).
    """

    model: Any
    hand: Int64
    robot: Int64
    worn: Int64
    rest_rad: Float64


def build_model(
    geometry: HandGeometry, patient: VirtualPatient, q_min_rad: Float64, q_max_rad: Float64
) -> HandModel:
    """The hand in the exoskeleton.

    Args:
        geometry: The patient's hand, of either side.
        patient: Stiffness and posture of its joints.
        q_min_rad: Lower end of the device's range, (12,).
        q_max_rad: Upper end of the device's range, (12,).
    """
    spec: Any = mujoco.MjSpec()
    spec.compiler.degree = False  # the default reads radian limits as degrees
    spec.option.timestep = PERIOD_S
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    soften(spec)
    add_palm_skin(spec, geometry)
    rest = patient.rest_rad()
    for digit in range(5):
        _add_digit(spec, geometry, patient, rest, digit)
        _add_links(spec, geometry, digit, q_min_rad, q_max_rad)
    _add_tendons(spec)
    model: Any = spec.compile()
    hand = np.array([model.joint(name).qposadr[0] for name in JOINTS])
    robot = np.array([model.joint(f"exo_{name}").qposadr[0] for name in DRIVEN])
    return HandModel(model, hand, robot, hand[[JOINTS.index(name) for name in DRIVEN]], rest)


def hand_landmarks(hand: HandModel, joints_rad: Float64) -> Float64:
    """Digit landmarks by MuJoCo's own kinematics, in the palm frame, order of LANDMARKS[:20], (20, 3)."""
    state: Any = mujoco.MjData(hand.model)
    state.qpos[hand.hand] = joints_rad
    mujoco.mj_kinematics(hand.model, state)
    return np.array([state.site(name).xpos for name in LANDMARKS[:20]])


def _bones(digit: int) -> tuple[tuple[str, ...], ...]:
    if digit == 0:
        return _THUMB_BONES
    name = DIGITS[digit]
    return (f"{name}_mcp_abduction", f"{name}_mcp_flexion"), (f"{name}_pip",), (f"{name}_dip",)


def _base_pose(geometry: HandGeometry, digit: int) -> dict[str, Float64]:
    """Position and quaternion of a digit's base; a mirror image is turned, not reflected."""
    mirror = geometry.mirror
    rotation = mirror[:, None] * geometry.base_rotation[digit] * mirror
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return {"pos": geometry.bases_m[digit] * mirror, "quat": quaternion}


def _axis(joint: str, geometry: HandGeometry) -> list[float]:
    """Flexion turns about +y on both sides; the axis of abduction changes its sign with the side."""
    return [-float(geometry.mirror[1]), 0.0, 0.0] if joint.endswith("abduction") else [0.0, 1.0, 0.0]


def _add_digit(spec: Any, geometry: HandGeometry, patient: VirtualPatient, rest: Float64, digit: int) -> None:
    parent, pose = spec.worldbody, _base_pose(geometry, digit)
    radius = bone_radius_m(geometry)
    names = LANDMARKS[4 * digit : 4 * digit + 4]
    for bone, joints in enumerate(_bones(digit)):
        length = float(geometry.bones_m[digit, bone])
        body = parent.add_body(name=f"{names[bone]}_bone", **pose, **_cylinder(length, radius))
        for joint in joints:
            angle = float(rest[JOINTS.index(joint)])
            body.add_joint(
                name=joint,
                axis=_axis(joint, geometry),
                armature=_TISSUE_INERTIA_KG_M2,
                stiffness=[_stiffness_nm_rad(joint, patient), 0.0, 0.0],
                damping=[patient.damping_nms_rad, 0.0, 0.0],
                springref=angle,
            )
        add_bone_skin(body, geometry, digit, bone)
        body.add_site(name=names[bone])
        parent, pose = body, {"pos": np.array([0.0, 0.0, length])}
    parent.add_site(name=names[3], pos=pose["pos"])


def _stiffness_nm_rad(joint: str, patient: VirtualPatient) -> float:
    """Passive stiffness; the DIP follows the PIP, which carries its share (0.6 of the MCP's)."""
    if joint.endswith("_dip"):
        return 0.0
    if joint not in DRIVEN:
        return _UNDRIVEN_STIFFNESS_NM_RAD
    share = 1.0 + 0.6 * DIP_PER_PIP**2 if joint.endswith("_pip") else 1.0
    return patient.stiffness_nm_rad * share


def _cylinder(length_m: float, radius_m: float) -> dict[str, Any]:
    mass = _TISSUE_DENSITY_KG_M3 * np.pi * radius_m**2 * length_m
    across, along = mass * (3 * radius_m**2 + length_m**2) / 12, mass * radius_m**2 / 2
    return {
        "mass": mass,
        "inertia": [across, across, along],
        "ipos": [0.0, 0.0, length_m / 2],
        "explicitinertial": True,
    }


def _add_links(spec: Any, geometry: HandGeometry, digit: int, q_min_rad: Float64, q_max_rad: Float64) -> None:
    parent, pose = spec.worldbody, _base_pose(geometry, digit)
    for bone, joints in enumerate(_bones(digit)):
        driven = [joint for joint in joints if joint in DRIVEN]
        if not driven:
            continue
        length = float(geometry.bones_m[digit, bone])
        link = {
            "mass": _LINK_MASS_KG,
            "inertia": [_LINK_MASS_KG * length**2 / 12] * 3,
            "explicitinertial": True,
        }
        body = parent.add_body(
            name=f"exo_{driven[-1]}_link", ipos=[-_LINK_DORSAL_M, 0.0, length / 2], **link, **pose
        )
        for joint in driven:
            column = DRIVEN.index(joint)
            body.add_joint(
                name=f"exo_{joint}",
                axis=_axis(joint, geometry),
                armature=ROTOR_INERTIA_KG_M2,
                damping=[1e-4, 0.0, 0.0],
                limited=mujoco.mjtLimited.mjLIMITED_TRUE,
                range=[q_min_rad[column] - _STOP_BEYOND_RAD, q_max_rad[column] + _STOP_BEYOND_RAD],
            )
        parent, pose = body, {"pos": np.array([0.0, 0.0, length])}


def _add_tendons(spec: Any) -> None:
    for joint in DRIVEN:
        strap = spec.add_tendon(
            name=f"strap_{joint}",
            stiffness=[STRAP_STIFFNESS_NM_RAD, 0.0, 0.0],
            damping=[STRAP_DAMPING_NMS_RAD, 0.0, 0.0],
            springlength=[0.0, 0.0],
        )
        strap.wrap_joint(f"exo_{joint}", 1.0)
        strap.wrap_joint(joint, -1.0)
    for finger in FINGERS:
        slip = spec.add_tendon(
            name=f"coupling_{finger}",
            stiffness=[_COUPLING_STIFFNESS_NM_RAD, 0.0, 0.0],
            damping=[_COUPLING_DAMPING_NMS_RAD, 0.0, 0.0],
            springlength=[0.0, 0.0],
        )
        slip.wrap_joint(f"{finger}_dip", 1.0)
        slip.wrap_joint(f"{finger}_pip", -DIP_PER_PIP)
