"""A target grip: the posture of one hand around an object, where the object lies, and the way still to go."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.errors import Refused
from rehab_app.grasp.grip import GRIPS
from rehab_app.grasp.hand import GraspHand, human_hand
from rehab_app.grasp.holding import held_range_m
from rehab_app.grasp.objects import Box, Cylinder, Sphere, Thing
from rehab_app.grasp.posture import Posture, try_posture
from rehab_app.grasp.shape import aperture_rad
from rehab_app.grasp.target_json import target_from_json
from rehab_app.services.grip_robot import robot_fingertips_m, robot_goal_m
from robot_iface.kinematics import HandGeometry, forward
from sessions.records import DIGITS, FINGERTIPS, JOINTS, LANDMARKS
from sessions.records.fields import Float64

KINDS = ("none", "cylinder", "ball", "box")
"""What can be chosen; ``none`` takes the target away."""
SMALLEST_MM, LARGEST_MM = 5.0, 300.0
_TIPS = [LANDMARKS.index(name) for name in FINGERTIPS]


@dataclass(frozen=True, slots=True)
class GripChoice:
    """What the therapist chose.

    Attributes:
        thing: The object.
        grip: transverse or diagonal.
    """

    thing: Thing
    grip: str

    @property
    def words(self) -> str:
        """Such as "Cylinder of 45 mm, transverse grip"."""
        thing = self.thing
        if isinstance(thing, Box):
            return f"Box of {1e3 * thing.depth_m:g} x {1e3 * thing.width_m:g} mm, {self.grip} grip"
        if isinstance(thing, Sphere):
            return f"Ball of {2e3 * thing.radius_m:g} mm"
        return f"Cylinder of {2e3 * thing.radius_m:g} mm, {self.grip} grip"


def grip_choice(
    kind: str, size_mm: float, grip: str = "transverse", width_mm: float = 0.0
) -> GripChoice | None:
    """The choice in the words of the screen.

    Args:
        kind: One of ``KINDS``.
        size_mm: Diameter of a cylinder or ball; thickness of a box, out of the palm.
        grip: transverse or diagonal; a ball has no axis, so there it says nothing.
        width_mm: Of a box, towards the fingertips.

    Returns:
        The choice; None for ``none``.

    Raises:
        Refused: A word is unknown, or a size is no object's.
    """
    if kind not in KINDS:
        raise Refused("target grip", repr(kind[:20]), "one of " + ", ".join(KINDS), "choose it from the list")
    if kind == "none":
        return None
    if grip not in GRIPS:
        raise Refused("grip", repr(grip[:20]), " or ".join(GRIPS), "choose it from the list")
    if kind == "box":
        return GripChoice(Box(_metres("thickness", size_mm), _metres("width", width_mm)), grip)
    radius_m = _metres("diameter", size_mm) / 2
    return (
        GripChoice(Sphere(radius_m), "transverse") if kind == "ball" else GripChoice(Cylinder(radius_m), grip)
    )


def recorded_choice(prescription: str) -> GripChoice | None:
    """The grip that a recording aimed at, by the prescription in its header; None of any other recording."""
    found = target_from_json(prescription)
    return None if found is None else GripChoice(found.thing, found.grip)


def choice_fields(choice: GripChoice | None) -> dict[str, str]:
    """A choice as the form of the screen holds it: object, size, width (mm) and grip."""
    if choice is None:
        return {"object": "none", "size": "60", "width": "60", "grip": "transverse"}
    thing = choice.thing
    if isinstance(thing, Box):
        size_mm, width_mm, kind = 1e3 * thing.depth_m, 1e3 * thing.width_m, "box"
    else:
        size_mm, width_mm, kind = (
            2e3 * thing.radius_m,
            60.0,
            "ball" if isinstance(thing, Sphere) else "cylinder",
        )
    return {"object": kind, "size": f"{size_mm:g}", "width": f"{width_mm:g}", "grip": choice.grip}


def _metres(thing: str, size_mm: float) -> float:
    if not SMALLEST_MM <= size_mm <= LARGEST_MM:
        bound = f"{SMALLEST_MM:g} to {LARGEST_MM:g} mm"
        raise Refused(f"{thing} of the object", f"{size_mm:g} mm", bound, "measure the object")
    return size_mm / 1e3


@dataclass(frozen=True, slots=True, eq=False)
class GripTarget:
    """A target posture for one hand. Arrays are never written after construction.

    Attributes:
        choice: What was chosen.
        geometry: The hand that it was made for.
        joints_rad: The posture, shape (21,).
        fingertips_m: Its fingertips in the palm frame, shape (5, 3), order of DIGITS.
        robot_fingertips_m: Those of the DLR-HIT-Hand II that shows it, in its own palm frame, shape (5, 3).
        holds: Which digits touch the object, shape (5,); the way to go is counted for these.
        aperture_rad: Angle at the wrist between the knuckles of thumb and index finger.
        p_palm_object_m: Middle of the object in the palm frame, shape (3,).
        r_palm_object: A rotation, shape (3, 3); its columns are the object's axes out of the palm, across and
            along itself.
        notes: What is not as it should be, each a sentence.
    """

    choice: GripChoice
    geometry: HandGeometry
    joints_rad: Float64
    fingertips_m: Float64
    robot_fingertips_m: Float64
    holds: NDArray[np.bool_]
    aperture_rad: float
    p_palm_object_m: Float64
    r_palm_object: Float64
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class WayToGo:
    """How far a hand is from a target grip.

    Attributes:
        fingertip_m: Distance of each fingertip from its place, shape (5,), order of DIGITS.
        farthest: The digit that is farthest, of those that touch the object.
        farthest_m: Its distance.
        aperture_rad: The hand's aperture now; None for the robot alone, whose thumb stands fixed.
    """

    fingertip_m: Float64
    farthest: str
    farthest_m: float
    aperture_rad: float | None


def make_target(choice: GripChoice, geometry: HandGeometry) -> GripTarget:
    """Compute the posture: a fraction of a second for round things, some seconds for boxes.

    Args:
        choice: Object and grip.
        geometry: The patient's hand.

    Raises:
        Refused: This hand cannot hold the object so; of round ones the sizes that it can are named.
    """
    hand = human_hand(geometry)
    try:
        posture = try_posture(hand, choice.thing, choice.grip, "contact", None)
    except Refused as refusal:
        raise _in_millimetres(refusal, hand, choice) from refusal
    joints = np.zeros(len(JOINTS))
    for name, angle in posture.angles_rad.items():
        joints[JOINTS.index(name)] = angle
    landmarks = forward(geometry, joints).landmarks_m
    middle, axes = _object_in_palm(posture, geometry)
    touching = {contact.digit for contact in posture.contacts}
    return GripTarget(
        choice=choice,
        geometry=geometry,
        joints_rad=joints,
        fingertips_m=landmarks[_TIPS],
        robot_fingertips_m=robot_goal_m(geometry, joints),
        holds=np.array([digit in touching for digit in DIGITS]),
        aperture_rad=float(aperture_rad(landmarks[None])[0]),
        p_palm_object_m=middle,
        r_palm_object=axes,
        notes=posture.warnings,
    )


def way_to_go(target: GripTarget, joints_rad: Float64, *, worn: bool = True) -> WayToGo | None:
    """How far a hand is from a target; None while part of it is not known.

    Args:
        target: The target, made for this hand.
        joints_rad: The hand's posture, shape (21,).
        worn: Whether a person's hand moved; else the DLR-HIT-Hand II alone, measured by its own fingertips.
    """
    if not worn:
        return _farthest(target, robot_fingertips_m(joints_rad) - target.robot_fingertips_m, None)
    landmarks = forward(target.geometry, joints_rad).landmarks_m
    aperture = float(aperture_rad(landmarks[None])[0])
    return _farthest(target, landmarks[_TIPS] - target.fingertips_m, aperture)


def _farthest(target: GripTarget, apart_m: Float64, aperture: float | None) -> WayToGo | None:
    """The way of fingertips that are apart by so much, shape (5, 3)."""
    away = np.linalg.norm(apart_m, axis=1)
    if not bool(np.isfinite(away).all()):
        return None
    worst = int(np.argmax(np.where(target.holds, away, -1.0)))
    return WayToGo(away, DIGITS[worst], float(away[worst]), aperture)


def _in_millimetres(refusal: Refused, hand: GraspHand, choice: GripChoice) -> Refused:
    """The refusal as the screen says it: round things by their diameter, with those that can be held."""
    thing, grip = choice.thing, choice.grip
    if isinstance(thing, Box):
        return refusal
    kind = type(thing)

    def holds(radius_m: float) -> bool:
        try:
            try_posture(hand, kind(radius_m), grip, "contact", None)
        except Refused:
            return False
        return True

    held = held_range_m(holds)
    bound = (
        "of a size that this hand holds, and none is"
        if held is None
        else f"{2e3 * held[0]:.0f} to {2e3 * held[1]:.0f} mm for this hand"
    )
    name = "Ball" if kind is Sphere else f"Cylinder in the {grip} grip"
    return Refused(name, f"{2e3 * thing.radius_m:g} mm thick", bound, "choose another size or grip")


def _object_in_palm(posture: Posture, geometry: HandGeometry) -> tuple[Float64, Float64]:
    """Middle (3,) and axes (3, 3) of the object in the palm frame: ``in_object_frame`` turned round."""
    hand, knuckles = posture.hand, posture.hand.knuckles_m
    cosine, sine = math.cos(posture.alpha_rad), math.sin(posture.alpha_rad)
    middle = knuckles[:, 1:].mean(axis=0) - knuckles[3, 1:]
    along_m = float(middle[0]) * cosine - (float(middle[1]) + posture.z_m) * sine
    lateral_m, distal_m = along_m * cosine, -along_m * sine
    place = np.array(
        [
            hand.palm_half_m + posture.thing.half_depth_m,
            knuckles[3, 1] + lateral_m,
            knuckles[3, 2] + distal_m - posture.z_m,
        ]
    )
    axes = np.array([[1.0, 0.0, 0.0], [0.0, sine, cosine], [0.0, cosine, -sine]]) * geometry.mirror[:, None]
    if np.linalg.det(axes) < 0:
        axes[:, 1] *= -1.0
    return place * geometry.mirror, axes
