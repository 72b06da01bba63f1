"""Tripod, pinch and lateral grips of a person's hand: pads of the digits on a small thing.

The thesis recorded these grips and left them for later work (section 6.2); there is no table to compare with.
The thing counts as a ball of its half thickness, pads as capsules; which of the many possible postures is
taken is decided by nearness to a hand at rest, so the posture is a plausible one, not a predicted one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from rehab_app.errors import Refused
from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.holding import FRICTION
from rehab_app.grasp.objects import Box, Thing
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, couple_dip, forward
from sessions.records import DIGITS, JOINTS
from sessions.records.fields import Float64

PRECISION_GRIPS = ("pinch", "tripod", "lateral")

_THUMB = ("thumb_cmc_flexion", "thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip")
_REST_RAD = {"mcp_flexion": 0.7, "pip": 0.7, "mcp_abduction": 0.0, "thumb_mcp_flexion": 0.3, "thumb_ip": 0.3}
_CONTACT_M = 5e-4  # what a soft pad gives without being asked
_REST_WEIGHT = 2e-4  # metres of contact error that a radian from rest is worth
_SLIPS_RAD = 2.0 * math.atan(FRICTION)
_FACING_WEIGHTS = (5e-3, 5e-4)


@dataclass(frozen=True, slots=True)
class PrecisionGrip:
    """A small thing between the digits.

    Attributes:
        grip: pinch, tripod or lateral.
        angles_rad: By joint; joints of digits that take no part are left out.
        centre_m: The thing's middle in the palm frame (right-hand form), shape (3,).
        gap_m: From each touching digit's surface to the thing's, by digit; negative is pressed-in pad.
        opposition_rad: Angle between the thumb's push and the opposite of the others' together; 0 is best.
        warnings: Each one sentence.
    """

    grip: str
    angles_rad: dict[str, float]
    centre_m: Float64
    gap_m: dict[str, float]
    opposition_rad: float
    warnings: tuple[str, ...]


def find_precision(hand: GraspHand, thing: Thing, grip: str) -> PrecisionGrip:
    """A posture that holds a small thing between thumb and fingertips, or the index finger's side.

    Args:
        hand: A person's hand; the robot's thumb has its opposition fixed and is refused.
        thing: What is held, by half its thickness.
        grip: pinch (thumb, index), tripod (and middle) or lateral (thumb on the side of the index finger).

    Raises:
        Refused: The hand is no person's, the grip is unknown, or the digits cannot meet around the thing.
    """
    if grip not in PRECISION_GRIPS:
        raise Refused("grip", repr(grip), " or ".join(PRECISION_GRIPS), "name one of these")
    if hand.person is None:
        raise Refused(f"{grip} grip", f"asked of {hand.name}", "one of a person's hand", "use --hand human")
    problem = _Problem(hand, thing, grip)
    best = min((problem.solved(start) for start in problem.starts()), key=lambda one: one[1])[0]
    gaps, opposition = problem.judged(best)
    widest = max(gaps, key=lambda digit: abs(gaps[digit]))
    if abs(gaps[widest]) > _CONTACT_M:
        raise Refused(
            f"{grip} grip",
            f"open: the {widest} stays {1e3 * abs(gaps[widest]):.1f} mm from touching rightly",
            f"within {1e3 * _CONTACT_M:g} mm",
            "choose another size",
        )
    if opposition > _SLIPS_RAD:
        raise Refused(
            f"{grip} grip",
            f"slipping: thumb and fingers push {math.degrees(opposition):.0f} deg past each other",
            f"at most {math.degrees(_SLIPS_RAD):.0f} deg",
            "choose another size",
        )
    said = (f"a {grip} grip is a plausible posture, not one that was measured or predicted",)
    return PrecisionGrip(grip, problem.angles(best), best[-3:].copy(), gaps, opposition, said)


class _Problem:
    """Unknown: the joints that take part, and the thing's middle."""

    def __init__(self, hand: GraspHand, thing: Thing, grip: str) -> None:
        assert hand.person is not None
        self._person = hand.person
        self._half_m = thing.half_depth_m
        if isinstance(thing, Box):
            self._half_m = min(thing.depth_m, thing.width_m) / 2
        fingers = ("index", "middle") if grip == "tripod" else ("index",)
        finger_link = 1 if grip == "lateral" else 2
        self._touch = [("thumb", 0, 2, float(hand.thumb_half_m[2]))]
        for finger in fingers:
            row = DIGITS.index(finger)
            self._touch.append((finger, row, finger_link, float(hand.half_m[row - 1, finger_link])))
        names = [
            *_THUMB,
            *(f"{finger}_{joint}" for finger in fingers for joint in ("mcp_flexion", "mcp_abduction", "pip")),
        ]
        self._names = tuple(names)
        self._joints = np.array([JOINTS.index(name) for name in names])
        self._rest = np.array(
            [_REST_RAD.get(name, _REST_RAD.get(name.partition("_")[2], 0.0)) for name in names]
        )
        self._lateral = grip == "lateral"

    def starts(self) -> list[Float64]:
        """Where to begin: the thing at several places before the palm, shape (J + 3,) each."""
        length_m = self._person.length_m
        places = [(0.30, 0.15, 0.45), (0.25, 0.22, 0.60), (0.15, 0.25, 0.50), (0.35, 0.10, 0.60)]
        return [np.concatenate([self._rest, length_m * np.array(place)]) for place in places]

    def solved(self, start: Float64) -> tuple[Float64, float]:
        """The nearest solution and its cost."""
        low = np.concatenate([JOINT_MIN_RAD[self._joints], np.full(3, -1.0)])
        high = np.concatenate([JOINT_MAX_RAD[self._joints], np.full(3, 1.0)])
        at = start
        cost = math.inf
        # first the pads face each other, then they meet: a small thing leaves no room for both at once
        for weight in _FACING_WEIGHTS:
            at = np.clip(at, low + 1e-6, high - 1e-6)
            found = least_squares(self._residual, at, bounds=(low, high), max_nfev=60, args=(weight,))
            at, cost = np.asarray(found.x, dtype=np.float64), float(found.cost)
        return at, cost

    def judged(self, unknown: Float64) -> tuple[dict[str, float], float]:
        """Gaps by digit, m, and how far thumb and fingers push past each other, rad."""
        gaps, pushes = self._contacts(unknown)
        others = pushes[1:].sum(axis=0)
        cosine = -float(pushes[0] @ others) / max(float(np.linalg.norm(others)), 1e-12)
        named = {touch[0]: float(gap) for touch, gap in zip(self._touch, gaps, strict=True)}
        return named, math.acos(min(1.0, max(-1.0, cosine)))

    def angles(self, unknown: Float64) -> dict[str, float]:
        """By joint, with the distal joints of the fingers that take part."""
        joints = self._whole(unknown)
        dips = [name.replace("_pip", "_dip") for name in self._names if name.endswith("_pip")]
        return {name: float(joints[JOINTS.index(name)]) for name in (*self._names, *dips)}

    def _whole(self, unknown: Float64) -> Float64:
        joints = np.zeros(len(JOINTS))
        joints[self._joints] = unknown[:-3]
        return couple_dip(joints)

    def _contacts(self, unknown: Float64) -> tuple[Float64, Float64]:
        """Gap of each touching link, shape (K,), and the direction in which it pushes, shape (K, 3)."""
        frames = forward(self._person, self._whole(unknown))
        points = (frames.landmarks_m[:20] * self._person.mirror).reshape(5, 4, 3)
        gaps, pushes = np.empty(len(self._touch)), np.empty((len(self._touch), 3))
        for row, (_, digit, link, half_m) in enumerate(self._touch):
            start, end = points[digit, link], points[digit, link + 1]
            way = end - start
            # the pad is the middle of the link: a contact at its very end is a nail, at its start a joint
            part = min(0.8, max(0.3, float((unknown[-3:] - start) @ way / (way @ way))))
            off = unknown[-3:] - start - part * way
            size = max(float(np.linalg.norm(off)), 1e-9)
            gaps[row], pushes[row] = size - half_m - self._half_m, off / size
        return gaps, pushes

    def _residual(self, unknown: Float64, weight: float) -> Float64:
        gaps, pushes = self._contacts(unknown)
        others = pushes[1:].sum(axis=0)
        facing = weight * (pushes[0] + others / max(float(np.linalg.norm(others)), 1e-9))
        frames = forward(self._person, self._whole(unknown))
        # fingers push with their palmar side; in the lateral grip the index finger's thumb side does
        wanted = np.stack(
            [
                frames.rotations[digit, link, :, 1 if self._lateral and digit else 0]
                for _, digit, link, _ in self._touch
            ]
        )
        inward = weight * (1.0 - (pushes * wanted * self._person.mirror).sum(axis=1))
        return np.concatenate([10 * gaps, facing, inward, _REST_WEIGHT * (unknown[:-3] - self._rest)])
