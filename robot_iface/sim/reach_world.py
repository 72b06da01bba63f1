"""The scene of the reach: arm, hand, a table, and a cylinder that stands free on it.

The world is the MIT-Manus frame, z up. The hand looks along -y, its thumb up, so that the cylinder's axis is
vertical and lies along the row of knuckles: the transverse grip, the only one that this arm allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robot_iface.errors import Refused
from robot_iface.kinematics.dlr_hit import dlr_hit_hand
from robot_iface.sim.dlr_hit import HAND_BIT, OBJECT_BIT, PALM_HALF_M, DlrHitAddresses, add_dlr_hit, addresses
from robot_iface.sim.engine import mujoco
from robot_iface.sim.reach_arm import ARM_LINKS_M, END_M, SHOULDER_M, START_M, WRIST_M, arm_inverse
from robot_iface.types import Float64, Int64

PERIOD_S = 0.001
WRIST_HEIGHT_M = 0.15
_ARM_LINK_MASS_KG = (1.0, 0.7)  # assumed: the thesis gives the arm's lengths only
_FLANGE_MASS_KG = 0.3
_ARM_ROTOR_KG_M2 = 0.01
_LEVEL_SOLREF = (0.002, 1.0)
_LEVEL_SOLIMP = (0.999, 0.9999, 0.001, 0.5, 2.0)
_FRICTION_RATIO = 10.0  # how much harder friction is than contact: a soft one would let a held object creep
_NO_SLIP_ROUNDS = 5
# columns: palmar, radial and distal axis of the palm in the MIT-Manus frame
_PALM_AXES: Float64 = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True, slots=True)
class FreeCylinder:
    """A cylinder that stands free, and where the hand will find it.

    Attributes:
        radius_m: Its radius.
        distal_m: Its axis from the wrist, along the palm frame's z, when the arm's end stands at ``END_M``.
        top_m: Its upper end over the wrist (the palm frame's y).
        height_m: From its upper end to the table.
        mass_kg: Its mass.
        friction: Sliding friction of everything that it touches.
    """

    radius_m: float
    distal_m: float
    top_m: float
    height_m: float = 0.09
    mass_kg: float = 0.1
    friction: float = 0.6

    def __post_init__(self) -> None:
        bounds = {
            "radius_m": (0.005, 0.06),
            "distal_m": (0.0, 0.25),
            "top_m": (-0.1, 0.2),
            "height_m": (0.02, 0.35),
            "mass_kg": (0.01, 2.0),
            "friction": (0.05, 2.0),
        }
        for name, (low, high) in bounds.items():
            value = float(getattr(self, name))
            if not low <= value <= high:
                raise Refused(f"cylinder {name}", f"{value:g}", f"{low:g} to {high:g}", "choose another")

    @property
    def centre_m(self) -> Float64:
        """Its middle in the MIT-Manus frame before anything touches it, shape (3,)."""
        palm = np.array([PALM_HALF_M + self.radius_m, self.top_m - self.height_m / 2, self.distal_m])
        return palm_to_world(palm, END_M)


@dataclass(frozen=True, slots=True)
class ReachWorld:
    """The compiled scene and where its parts stand in MuJoCo's arrays.

    Attributes:
        model: The compiled ``mujoco.MjModel``.
        hand: The hand's addresses.
        arm: Address of shoulder, elbow and levelled wrist, in both qpos and qvel, shape (3,).
        cylinder: The cylinder among the bodies.
        cylinder_geom: The cylinder among the surfaces.
        table_geom: The table among the surfaces.
    """

    model: Any
    hand: DlrHitAddresses
    arm: Int64
    cylinder: int
    cylinder_geom: int
    table_geom: int


def palm_to_world(point_m: Float64, end_m: Float64) -> Float64:
    """A point of the palm frame in the MIT-Manus frame, with the arm's end at a place of its plane."""
    wrist = np.array([*(end_m + WRIST_M), WRIST_HEIGHT_M])
    return wrist + point_m @ _PALM_AXES.T


def build_world(cylinder: FreeCylinder) -> ReachWorld:
    """Arm, hand, table and cylinder, the arm at its start."""
    spec: Any = mujoco.MjSpec()
    spec.compiler.degree = False  # the default reads radian limits as degrees
    spec.option.timestep = PERIOD_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = _FRICTION_RATIO
    spec.option.noslip_iterations = _NO_SLIP_ROUNDS
    _add_hand_on_arm(spec, cylinder.friction)
    _add_scene(spec, cylinder)
    model: Any = spec.compile()
    names = ("shoulder", "elbow", "level")
    return ReachWorld(
        model=model,
        hand=addresses(model),
        arm=np.array([model.joint(name).qposadr[0] for name in names]),
        cylinder=int(model.body("cylinder").id),
        cylinder_geom=int(model.geom("cylinder").id),
        table_geom=int(model.geom("table").id),
    )


def start_state(world: ReachWorld) -> Any:
    """The scene at rest: arm at its start, fingers straight."""
    state: Any = mujoco.MjData(world.model)
    shoulder, elbow = arm_inverse(START_M)
    state.qpos[world.arm] = [shoulder, elbow, -shoulder - elbow]
    mujoco.mj_forward(world.model, state)
    return state


def _add_hand_on_arm(spec: Any, friction: float) -> None:
    parent, pos = spec.worldbody, [*SHOULDER_M, WRIST_HEIGHT_M]
    for name, length, mass in zip(("shoulder", "elbow"), ARM_LINKS_M, _ARM_LINK_MASS_KG, strict=True):
        inertia = mass * length**2 / 12
        body = parent.add_body(
            name=f"{name}_link",
            pos=pos,
            mass=mass,
            ipos=[length / 2, 0.0, 0.0],
            inertia=[1e-3, inertia, inertia],
            explicitinertial=True,
            gravcomp=1.0,
        )
        body.add_joint(name=name, axis=[0.0, 0.0, 1.0], armature=_ARM_ROTOR_KG_M2)
        parent, pos = body, [length, 0.0, 0.0]
    flange = parent.add_body(
        name="flange",
        pos=pos,
        mass=_FLANGE_MASS_KG,
        inertia=[1e-3] * 3,
        explicitinertial=True,
        gravcomp=1.0,
    )
    flange.add_joint(name="level", axis=[0.0, 0.0, 1.0])
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(_PALM_AXES).ravel())
    add_dlr_hit(spec, flange, dlr_hit_hand(), np.array([*WRIST_M, 0.0]), quaternion, friction)
    _keep_level(spec)


def _keep_level(spec: Any) -> None:
    """The hand never turns: the three angles of the arm sum to zero, as a parallel linkage would have it."""
    sum_of_angles = spec.add_tendon(name="heading")
    for name in ("shoulder", "elbow", "level"):
        sum_of_angles.wrap_joint(name, 1.0)
    spec.add_equality(
        name="heading",
        type=mujoco.mjtEq.mjEQ_TENDON,
        objtype=mujoco.mjtObj.mjOBJ_TENDON,
        name1="heading",
        data=[0.0] * 12,
        solref=_LEVEL_SOLREF,
        solimp=_LEVEL_SOLIMP,
    )


def _add_scene(spec: Any, cylinder: FreeCylinder) -> None:
    centre, half = cylinder.centre_m, cylinder.height_m / 2
    surface = {"friction": [cylinder.friction, 0.005, 1e-4], "condim": 4}
    spec.worldbody.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[0.0, -0.25, centre[2] - half - 0.01],
        size=[0.4, 0.25, 0.01],
        contype=HAND_BIT,  # the table holds up the object and lets the hand pass
        conaffinity=OBJECT_BIT,
        **surface,
    )
    body = spec.worldbody.add_body(name="cylinder", pos=centre)
    body.add_freejoint(name="cylinder")
    body.add_geom(
        name="cylinder",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[cylinder.radius_m, half, 0.0],
        mass=cylinder.mass_kg,
        contype=OBJECT_BIT,
        conaffinity=HAND_BIT,
        **surface,
    )
