"""A hand as a grasp sees it: knuckles, phalanges, thicknesses, ranges; the robot's and any person's."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.objects import named_sizes
from robot_iface.kinematics import DIP_PER_PIP, JOINT_MAX_RAD, JOINT_MIN_RAD, HandGeometry, average_hand
from robot_iface.kinematics.dlr_hit import (
    FINGER_MAX_RAD,
    FINGER_MIN_RAD,
    LINKS_M,
    DlrHitHand,
    dlr_hit_hand,
)
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64

ROBOT = "dlr-hit-ii"

# Half of the full thicknesses of Table 5.2; with the full ones nothing lands near the thesis.
_ROBOT_PALM_M = 0.031
_ROBOT_HALF_M = np.array([0.0175, 0.013, 0.012])
# Half thicknesses of a person's palm and phalanges as parts of hand length (29, 18, 16 and 13 mm for a hand
# of 189 mm): usual sizes of adult hands, assumed to grow with it.
_PALM_PART = 0.0145 / 0.189
_HALF_PARTS = np.array([0.0090, 0.0080, 0.0065]) / 0.189
_LITTLE_SHARE = 0.85
_THUMB_HALF_PARTS = np.array([0.0110, 0.0100, 0.0085]) / 0.189


@dataclass(frozen=True, slots=True)
class GraspHand:
    """One hand, stated for its right-hand form; palm frame: x palmar, y radial, z distal.

    Attributes:
        name: ``dlr-hit-ii`` or ``human``.
        side: Side of the hand; angles mean the same on both.
        knuckles_m: First joint of index, middle, ring and little, shape (4, 3).
        thesis_yz_m: The same as chapter 5 is computed with: lateral and distal, shape (4, 2).
        links_m: Proximal, medial and distal link, shape (4, 3).
        palm_half_m: From the plane of the knuckles to the palm's surface.
        half_m: Half thickness of each link, shape (4, 3).
        thumb_half_m: Half thickness of the thumb's three links, shape (3,).
        dip_per_pip: Flexion of the distal joint per flexion of the middle one.
        mcp_min_rad: Farthest extension of the knuckles; a grip itself starts at straight ones.
        mcp_max_rad: Largest flexion of the knuckles.
        pip_max_rad: Largest flexion of the middle joints, with the coupled distal joint in its range too.
        person: Kinematics of a person's hand.
        robot: Kinematics of the robot's hand; one of the two is there.
    """

    name: str
    side: Side
    knuckles_m: Float64
    thesis_yz_m: Float64
    links_m: Float64
    palm_half_m: float
    half_m: Float64
    thumb_half_m: Float64
    dip_per_pip: float
    mcp_min_rad: float
    mcp_max_rad: float
    pip_max_rad: float
    person: HandGeometry | None = None
    robot: DlrHitHand | None = None


def robot_hand() -> GraspHand:
    """The DLR-HIT-Hand II."""
    robot = dlr_hit_hand()
    distal = np.sqrt(robot.distance_m**2 - robot.lateral_m**2)
    return GraspHand(
        name=ROBOT,
        side="right",
        knuckles_m=robot.bases_m[1:],
        thesis_yz_m=np.stack([robot.lateral_m, distal], axis=1),
        links_m=np.tile(np.array(LINKS_M), (4, 1)),
        palm_half_m=_ROBOT_PALM_M,
        half_m=np.tile(_ROBOT_HALF_M, (4, 1)),
        thumb_half_m=_ROBOT_HALF_M,
        dip_per_pip=1.0,
        mcp_min_rad=float(FINGER_MIN_RAD[1]),
        mcp_max_rad=float(FINGER_MAX_RAD[1]),
        pip_max_rad=float(FINGER_MAX_RAD[2]),
        robot=robot,
    )


def human_hand(geometry: HandGeometry) -> GraspHand:
    """A person's hand: measured bones where they are known, average thicknesses for its length."""
    length_m = geometry.length_m
    half = np.tile(_HALF_PARTS * length_m, (4, 1))
    half[3] *= _LITTLE_SHARE
    pip, dip = JOINTS.index("index_pip"), JOINTS.index("index_dip")
    return GraspHand(
        name="human",
        side=geometry.side,
        knuckles_m=geometry.bases_m[1:],
        thesis_yz_m=geometry.bases_m[1:, 1:],
        links_m=geometry.bones_m[1:],
        palm_half_m=_PALM_PART * length_m,
        half_m=half,
        thumb_half_m=_THUMB_HALF_PARTS * length_m,
        dip_per_pip=DIP_PER_PIP,
        mcp_min_rad=float(JOINT_MIN_RAD[JOINTS.index("index_mcp_flexion")]),
        mcp_max_rad=float(JOINT_MAX_RAD[JOINTS.index("index_mcp_flexion")]),
        pip_max_rad=min(float(JOINT_MAX_RAD[pip]), float(JOINT_MAX_RAD[dip]) / DIP_PER_PIP),
        person=geometry,
    )


def coupled(hand: GraspHand, dip_per_pip: float) -> GraspHand:
    """The same hand with another coupling of its distal joints.

    Raises:
        Refused: The coupling is not between 0 and 1.5.
    """
    if not 0.0 <= dip_per_pip <= 1.5:
        raise Refused("--dip-per-pip", f"{dip_per_pip:g}", "0 to 1.5", "use 1 or 0.667")
    return replace(hand, dip_per_pip=dip_per_pip)


def parse_hand(text: str, side: Side = "right") -> GraspHand:
    """The hand of a text: ``dlr-hit-ii``, ``human`` or ``human:length=0.189`` (metres).

    Raises:
        Refused: The text names no hand, the robot is asked for as a left hand, or the length is no person's.
    """
    kind, _, rest = text.partition(":")
    sizes = named_sizes("hand", text, rest)
    if kind == ROBOT and not sizes:
        if side != "right":
            raise Refused("hand", f"{ROBOT} as a {side} hand", "a right hand", "use --side right")
        return robot_hand()
    if kind == "human" and set(sizes) <= {"length"}:
        return human_hand(average_hand(sizes.get("length", 0.189), side))
    raise Refused("hand", repr(text), f"{ROBOT} or human:length=L in metres", "name one of these")
