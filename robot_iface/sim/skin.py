"""Skin of the simulated hand: capsules round the bones, a box for the palm, and who may touch whom.

Only pairs that a hand can bring together are tested: the thumb's two outer bones with every bone of the
fingers, the two outer bones of a finger with the palm, the thumb's tip with the palm. Neighbouring fingers
touch all the time and hold nothing; the exoskeleton's links lie behind the hand and touch nothing.
"""

from __future__ import annotations

from typing import Any

from robot_iface.kinematics import HandGeometry
from robot_iface.sim.engine import mujoco
from robot_iface.types import DIGITS

PALM_BIT, THUMB_BIT, FINGER_BIT = 1, 2, 4
_RADIUS_PER_LENGTH = 0.045
_SLENDER = (1.0, 0.9, 0.8)  # the outer bones are thinner
_PALM_HALF_PER_LENGTH = 0.055
_PALM_FROM, _PALM_TO = 0.08, 0.85  # of the way from the wrist to the little finger's knuckle
_SOLREF = (0.008, 1.0)  # skin and pulp give way: eight periods, critically damped
_SOLIMP = (0.8, 0.95, 0.003, 0.5, 2.0)


def bone_radius_m(geometry: HandGeometry) -> float:
    """Half the thickness of a digit."""
    return _RADIUS_PER_LENGTH * geometry.length_m


def soften(spec: Any) -> None:
    """The engine's settings for contacts of skin: the cheapest cone, as skin is taken to be smooth."""
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL


def add_palm_skin(spec: Any, geometry: HandGeometry) -> None:
    """The palm's box, from the wrist nearly to the knuckles."""
    fingers, thick = geometry.bases_m[1:], _PALM_HALF_PER_LENGTH * geometry.length_m
    low, high = _PALM_FROM * float(fingers[:, 2].min()), _PALM_TO * float(fingers[:, 2].min())
    edge = bone_radius_m(geometry)  # beyond the outer knuckles
    ulnar, radial = float(fingers[:, 1].min()) - edge, float(fingers[:, 1].max()) + edge
    spec.worldbody.add_geom(
        name="palm_skin",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[0.0, float(geometry.mirror[1]) * (ulnar + radial) / 2, (low + high) / 2],
        size=[thick, (radial - ulnar) / 2, (high - low) / 2],
        contype=PALM_BIT,
        conaffinity=0,
        **_skin(),
    )


def add_bone_skin(body: Any, geometry: HandGeometry, digit: int, bone: int) -> None:
    """The capsule round a bone, if the bone can touch anything."""
    if digit == 0 and bone == 0:
        return  # the thumb's metacarpal lies within the palm's own flesh
    length, radius = float(geometry.bones_m[digit, bone]), bone_radius_m(geometry) * _SLENDER[bone]
    outer = bone == 2 if digit == 0 else bone > 0
    body.add_geom(
        name=f"{DIGITS[digit]}_{bone}_skin",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=[0.0, 0.0, 0.0, 0.0, 0.0, length],
        size=[radius, 0.0, 0.0],
        contype=THUMB_BIT if digit == 0 else 0,
        conaffinity=(PALM_BIT if outer else 0) | (0 if digit == 0 else THUMB_BIT),
        **_skin(),
    )


def _skin() -> dict[str, Any]:
    return {"condim": 1, "solref": _SOLREF, "solimp": _SOLIMP, "mass": 0.0}
