"""The thumb: brought to the aperture that people keep (chapter 3), then closed to contact."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.closing import CONTACT_M, first_contact, in_object_frame
from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.objects import Thing
from rehab_app.grasp.tangent import tangent
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, HandGeometry, forward
from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, LINKS_M, DlrHitHand, hand_points
from sessions.records import JOINTS
from sessions.records.fields import Float64

APERTURE_RAD = {"transverse": float(np.deg2rad(56.08)), "diagonal": float(np.deg2rad(52.48))}
"""Angle at the wrist between the knuckles of thumb and index finger: means of Table 3.6, rad."""

_CMC_FLEXION, _CMC_ABDUCTION, _MCP, _IP = (
    JOINTS.index(f"thumb_{name}") for name in ("cmc_flexion", "cmc_abduction", "mcp_flexion", "ip")
)
_ABDUCTIONS = 16
_FLEXIONS = 15
_HALVINGS, _APERTURE_HALVINGS = 28, 20
# The rule comes from one cylinder of 60 mm: where it leaves the thumb off the object, others are tried.
_OFF_RULE_RAD = np.deg2rad([0.0, -5.0, 5.0, -10.0, 10.0])


@dataclass(frozen=True, slots=True)
class Thumb:
    """A thumb closed around an object, or left open where no posture clears it.

    Attributes:
        angles_rad: By joint name.
        points_m: Base, middle joint, last joint and tip in the palm frame (right-hand form), shape (4, 3).
        gap_m: From each link's surface to the object's, shape (3,); negative is penetration.
        aperture_rad: Angle at the wrist between the knuckles of thumb and index finger.
        holds: Whether it touches the object without cutting it.
    """

    angles_rad: dict[str, float]
    points_m: Float64
    gap_m: Float64
    aperture_rad: float
    holds: bool


def close_thumb(hand: GraspHand, thing: Thing, z_m: float, alpha_rad: float, aperture_rad: float) -> Thumb:
    """The thumb that clears the object, keeps the aperture, and brings its joints nearest to the surface.

    Args:
        hand: The hand.
        thing: The object.
        z_m: Height of the little finger's knuckle over the object's axis.
        alpha_rad: Inclination of the object.
        aperture_rad: Aperture to keep; the robot's is fixed by its geometry.
    """
    chain = _chain(hand, aperture_rad)
    largest = chain.largest_rad

    def gap(first: Float64, second: Float64) -> Float64:
        points = chain.points_m(first, second)
        placed = in_object_frame(
            hand, thing, np.full(len(points), z_m), np.full(len(points), alpha_rad), points
        )
        return thing.distance_m(placed[:, :-1], placed[:, 1:]) - hand.thumb_half_m

    zero = np.zeros(len(chain.starts_rad))
    share = chain.together * largest[1] / largest[0]
    first, met_first = first_contact(
        lambda angle: gap(angle, share * angle)[:, chain.moved :].min(axis=1),
        zero,
        largest[0],
        _HALVINGS,
    )
    first = np.where(met_first, first, 0.0)
    begun = share * first
    more, met_second = first_contact(
        lambda angle: gap(first, np.minimum(begun + angle, largest[1]))[:, chain.moved + 1 :].min(axis=1),
        zero,
        largest[1],
        _HALVINGS,
    )
    second = np.where(met_second, np.minimum(begun + more, largest[1]), begun)
    gaps = gap(first, second)
    holds = (gaps.min(axis=1) >= -CONTACT_M) & (met_first | met_second)
    # the aperture is kept first, then the joints come near; where nothing holds, the least cut is shown
    nearness = gaps.sum(axis=1) + 10.0 * np.abs(chain.apertures_rad - aperture_rad)
    best = int(np.argmin(np.where(holds, nearness, 1e3 - gaps.min(axis=1))))
    points = chain.points_m(first, second)[best]
    return Thumb(
        chain.angles(best, float(first[best]), float(second[best])),
        points,
        gaps[best],
        float(chain.apertures_rad[best]),
        bool(holds[best]),
    )


def tangent_thumb(hand: GraspHand, radius_m: float) -> Thumb:
    """The robot's thumb as the thesis has it: its own distances least (eqs. 5.2 to 5.4), its base fixed.

    Args:
        hand: The robot.
        radius_m: Radius of the cylinder.
    """
    assert hand.robot is not None
    links, half = np.array(LINKS_M), hand.thumb_half_m
    heights = np.linspace(-0.03, 0.03, 601)
    touch = tangent(heights, radius_m, links, hand.palm_half_m, half)
    least = int(np.argmin(touch.centre_m.sum(axis=1)))
    first, second = float(touch.mcp_rad[least]), float(touch.pip_rad[least])
    for angle, limit in zip((first, second), FINGER_MAX_RAD[1:], strict=True):
        if not 0.0 <= angle <= limit:
            raise Refused("thumb angle", f"{angle:.4g} rad", f"0 to {limit:.4g} rad", "choose another radius")
    chain = _RobotThumb(hand.robot)
    middle = len(chain.starts_rad) // 2
    points = chain.points_m(np.full(len(chain.starts_rad), first), np.full(len(chain.starts_rad), second))
    return Thumb(
        chain.angles(middle, first, second),
        points[middle],
        np.zeros(3),
        float(chain.apertures_rad[middle]),
        holds=False,
    )


class _HumanThumb:
    """A person's thumb: base joints by the aperture, then MCP and IP flexion."""

    moved = 1
    """The first link that the first flexion moves."""
    together = 1.0
    """How far the last joint closes along with the one before it."""

    def __init__(self, geometry: HandGeometry, aperture_rad: float) -> None:
        self._geometry = replace(geometry, side="right")
        one = np.linspace(JOINT_MIN_RAD[_CMC_ABDUCTION], JOINT_MAX_RAD[_CMC_ABDUCTION], _ABDUCTIONS)
        abduction = np.tile(one, len(_OFF_RULE_RAD))
        wanted = np.repeat(aperture_rad + _OFF_RULE_RAD, len(one))
        flexion = self._flexion(abduction, wanted)
        self.starts_rad = np.stack([flexion, np.tile(abduction, 2)], axis=1)
        self.apertures_rad = self._aperture(flexion, self.starts_rad[:, 1])
        self.largest_rad = float(JOINT_MAX_RAD[_MCP]), float(JOINT_MAX_RAD[_IP])

    def _flexion(self, abduction: Float64, wanted: Float64) -> Float64:
        """First, then last flexion that gives each wanted aperture, or the nearest, shape (2 K,) for K.

        An aperture can have two flexions: the thumb goes away from the index finger and comes back.
        """
        flexion = np.linspace(JOINT_MIN_RAD[_CMC_FLEXION], JOINT_MAX_RAD[_CMC_FLEXION], _FLEXIONS)
        over = self._aperture(*(grid.ravel() for grid in np.meshgrid(flexion, abduction, indexing="ij")))
        over = over.reshape(_FLEXIONS, -1) - wanted
        crossing = np.diff(np.sign(over), axis=0) != 0
        crosses = np.tile(np.logical_or.reduce(crossing, axis=0), 2)
        at = np.concatenate([np.argmax(crossing, axis=0), _FLEXIONS - 2 - np.argmax(crossing[::-1], axis=0)])
        nearest = np.tile(flexion[np.argmin(np.abs(over), axis=0)], 2)
        low, high = np.where(crosses, flexion[at], nearest), np.where(crosses, flexion[at + 1], nearest)
        below = np.sign(over[at, np.tile(np.arange(len(abduction)), 2)])
        abduction, wanted = np.tile(abduction, 2), np.tile(wanted, 2)
        for _ in range(_APERTURE_HALVINGS):
            middle = (low + high) / 2
            same = np.sign(self._aperture(middle, abduction) - wanted) == below
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return low

    def points_m(self, first: Float64, second: Float64) -> Float64:
        return self._landmarks(self.starts_rad[:, 0], self.starts_rad[:, 1], first, second)[:, :4]

    def angles(self, row: int, first: float, second: float) -> dict[str, float]:
        flexion, abduction = self.starts_rad[row]
        names = "cmc_flexion", "cmc_abduction", "mcp_flexion", "mcp_abduction", "ip"
        values = float(flexion), float(abduction), first, 0.0, second
        return {f"thumb_{name}": value for name, value in zip(names, values, strict=True)}

    def _landmarks(self, flexion: Float64, abduction: Float64, mcp: Float64, ip: Float64) -> Float64:
        joints = np.zeros((len(flexion), len(JOINTS)))
        for index, angle in ((_CMC_FLEXION, flexion), (_CMC_ABDUCTION, abduction), (_MCP, mcp), (_IP, ip)):
            joints[:, index] = angle
        return forward(self._geometry, joints).landmarks_m

    def _aperture(self, flexion: Float64, abduction: Float64) -> Float64:
        zero = np.zeros_like(flexion)
        return _angle(self._landmarks(flexion, abduction, zero, zero)[:, 1], self._geometry.bases_m[1])


class _RobotThumb:
    """The robot's thumb: a finger like the others whose base is fixed."""

    moved = 0
    """The first link that the first flexion moves."""
    together = 0.0
    """How far the last joints close along with the first."""

    def __init__(self, robot: DlrHitHand) -> None:
        self._robot = robot
        self.starts_rad = np.linspace(FINGER_MIN_RAD[0], FINGER_MAX_RAD[0], 13)[:, None]
        self.apertures_rad = np.full(len(self.starts_rad), float(_angle(robot.bases_m[0], robot.bases_m[1])))
        self.largest_rad = float(FINGER_MAX_RAD[1]), float(FINGER_MAX_RAD[2])

    def points_m(self, first: Float64, second: Float64) -> Float64:
        joints = np.zeros((len(first), 5, 3))
        joints[:, 0] = np.stack([self.starts_rad[:, 0], first, second], axis=1)
        return hand_points(self._robot, joints)[:, 0]

    def angles(self, row: int, first: float, second: float) -> dict[str, float]:
        names = "cmc_abduction", "cmc_flexion", "mcp_flexion", "ip"
        values = float(self.starts_rad[row, 0]), first, second, second
        return {f"thumb_{name}": value for name, value in zip(names, values, strict=True)}


def _chain(hand: GraspHand, aperture_rad: float) -> _HumanThumb | _RobotThumb:
    if hand.robot is not None:
        return _RobotThumb(hand.robot)
    assert hand.person is not None
    return _HumanThumb(hand.person, aperture_rad)


def _angle(first: Float64, second: Float64) -> Float64:
    """Angle between vectors, shape (...), rad."""
    cosine = (first * second).sum(axis=-1) / (
        np.linalg.norm(first, axis=-1) * np.linalg.norm(second, axis=-1)
    )
    return np.arccos(np.clip(cosine, -1.0, 1.0))
