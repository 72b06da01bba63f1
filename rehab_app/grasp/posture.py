"""Which posture should a hand take around this object: the whole hand, its contacts, what is not right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.closing import CONTACT_M, in_object_frame
from rehab_app.grasp.curvature import joint_radius_m
from rehab_app.grasp.grip import GRIPS, STEEPEST_RAD, Fingers, contact_fingers, thesis_fingers
from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.holding import HOLDING_ARC_RAD, finger_arc_rad, holdable, thumb_arc_rad
from rehab_app.grasp.objects import Box, Sphere, Thing
from rehab_app.grasp.thumb import APERTURE_RAD, Thumb, close_thumb, tangent_thumb
from sessions.records import FINGERS
from sessions.records.fields import Float64

METHODS = ("contact", "thesis")
_LINKS = ("proximal", "medial", "distal")
_THUMB_LINKS = ("metacarpal", "proximal", "distal")


@dataclass(frozen=True, slots=True)
class Contact:
    """One place where the hand touches the object.

    Attributes:
        digit: Digit, or ``palm``.
        link: proximal, medial or distal (thumb: metacarpal, proximal, distal), or ``palm``.
        gap_m: Distance between the surfaces.
    """

    digit: str
    link: str
    gap_m: float


@dataclass(frozen=True, slots=True)
class Posture:
    """A hand around an object.

    Attributes:
        hand: The hand.
        thing: The object.
        grip: transverse or diagonal.
        method: contact or thesis.
        z_m: Height of the little finger's knuckle over the object's axis (eq. 5.5).
        alpha_rad: Inclination of the object's axis against the row of knuckles.
        objective_m: Sum of the distances of the long fingers' joints from the surface (eq. 5.1).
        angles_rad: By joint.
        radius_m: Radius of curvature at the joint axes by digit: pip and dip; thumb: mcp and ip.
            Infinite in a straight digit.
        contacts: Where the hand touches.
        penetration_m: Deepest cut of any digit into the object; 0 where none does.
        arc_rad: How far around the object the hand reaches: fingers, and thumb if it stands clear.
        aperture_rad: Angle at the wrist between the knuckles of thumb and index finger.
        warnings: Each one sentence.
        points_m: Joints and tip of each digit in the object's frame (depth, across, along), right-hand form,
            thumb first, shape (5, 4, 3).
    """

    hand: GraspHand
    thing: Thing
    grip: str
    method: str
    z_m: float
    alpha_rad: float
    objective_m: float
    angles_rad: dict[str, float]
    radius_m: dict[str, dict[str, float]]
    contacts: tuple[Contact, ...]
    penetration_m: float
    arc_rad: float
    aperture_rad: float
    warnings: tuple[str, ...]
    points_m: Float64


def find_posture(
    hand: GraspHand,
    thing: Thing,
    grip: str = "transverse",
    method: str = "contact",
    alpha_rad: float | None = None,
) -> Posture:
    """As ``try_posture``; a round object that is refused is refused with the sizes that this hand can hold.

    Raises:
        Refused: As ``try_posture``.
    """
    try:
        return try_posture(hand, thing, grip, method, alpha_rad)
    except Refused as refusal:
        if isinstance(thing, Box) or (isinstance(thing, Sphere) and method == "thesis"):
            raise
        _check(grip, method, alpha_rad)
        kind = type(thing)

        def holds(radius_m: float) -> bool:
            try:
                try_posture(hand, kind(radius_m), grip, method, alpha_rad)
            except Refused:
                return False
            return True

        raise Refused(
            f"{kind.__name__.lower()} radius",
            f"{thing.radius_m:g} m ({refusal.thing} is {refusal.value})",
            f"{holdable(holds)} for this hand",
            "choose another object, grip or inclination",
        ) from refusal


def try_posture(hand: GraspHand, thing: Thing, grip: str, method: str, alpha_rad: float | None) -> Posture:
    """The target posture of a volar grip.

    Args:
        hand: The hand.
        thing: The object.
        grip: transverse or diagonal.
        method: ``contact`` closes every finger until it touches; ``thesis`` lays every link tangent.
        alpha_rad: Inclination of the object; free unless given.

    Raises:
        Refused: An unknown grip or method, an inclination beyond 60 degrees, or an object that this hand
            cannot hold so.
    """
    _check(grip, method, alpha_rad)
    if method == "thesis":
        fingers = thesis_fingers(hand, thing, alpha_rad)
    else:
        fingers = contact_fingers(hand, thing, grip, alpha_rad)
    if method == "thesis" and hand.robot is not None:
        thumb = tangent_thumb(hand, thing.half_depth_m)
    else:
        thumb = close_thumb(hand, thing, fingers.z_m, fingers.alpha_rad, APERTURE_RAD[grip])
    posture = _whole(hand, thing, grip, method, fingers, thumb)
    if method == "contact" and posture.arc_rad < HOLDING_ARC_RAD:
        raise Refused(
            "grip",
            f"open: the hand reaches {math.degrees(posture.arc_rad):.0f} deg around the object",
            f"at least {math.degrees(HOLDING_ARC_RAD):.0f} deg",
            "choose a smaller object",
        )
    return posture


def _check(grip: str, method: str, alpha_rad: float | None) -> None:
    for thing, value, known in (("grip", grip, GRIPS), ("method", method, METHODS)):
        if value not in known:
            raise Refused(thing, repr(value), " or ".join(known), "name one of these")
    if alpha_rad is not None and not abs(alpha_rad) <= STEEPEST_RAD:
        raise Refused(
            "inclination",
            f"{alpha_rad:g} rad",
            f"-{STEEPEST_RAD:.4g} to {STEEPEST_RAD:.4g} rad",
            "turn the object",
        )


def _whole(hand: GraspHand, thing: Thing, grip: str, method: str, fingers: Fingers, thumb: Thumb) -> Posture:
    placed = in_object_frame(
        hand, thing, np.array([fingers.z_m]), np.array([fingers.alpha_rad]), thumb.points_m
    )[0]
    points = np.concatenate([placed[None], fingers.points_m])
    cut_m = min(0.0, float(fingers.gap_m.min()), float(thumb.gap_m.min()) if thumb.holds else 0.0)
    # a thumb that stands clear opposes the fingers even where this model does not bring it to the surface
    clear = float(thumb.gap_m.min()) >= -CONTACT_M
    thumb_arc = thumb_arc_rad(placed) if clear else 0.0
    return Posture(
        hand=hand,
        thing=thing,
        grip=grip,
        method=method,
        z_m=fingers.z_m,
        alpha_rad=fingers.alpha_rad,
        objective_m=fingers.objective_m,
        angles_rad={**thumb.angles_rad, **_angles(hand, fingers)},
        radius_m=_radii(points),
        contacts=_contacts(hand, fingers, thumb),
        penetration_m=abs(cut_m),
        arc_rad=finger_arc_rad(fingers.points_m) + thumb_arc,
        aperture_rad=thumb.aperture_rad,
        warnings=(*fingers.warnings, *_thumb_warnings(hand, grip, method, thumb)),
        points_m=points,
    )


def _angles(hand: GraspHand, fingers: Fingers) -> dict[str, float]:
    angles: dict[str, float] = {}
    for index, finger in enumerate(FINGERS):
        mcp, pip = float(fingers.mcp_rad[index]), float(fingers.pip_rad[index])
        angles |= {
            f"{finger}_mcp_flexion": mcp,
            f"{finger}_mcp_abduction": 0.0,
            f"{finger}_pip": pip,
            f"{finger}_dip": hand.dip_per_pip * pip,
        }
    return angles


def _radii(points_m: Float64) -> dict[str, dict[str, float]]:
    radius = joint_radius_m(points_m)
    table = {"thumb": {"mcp": float(radius[0, 0]), "ip": float(radius[0, 1])}}
    for index, finger in enumerate(FINGERS, start=1):
        table[finger] = {"pip": float(radius[index, 0]), "dip": float(radius[index, 1])}
    return table


def _contacts(hand: GraspHand, fingers: Fingers, thumb: Thumb) -> tuple[Contact, ...]:
    found = []
    if bool((fingers.points_m[:, 0, 1] >= 0.0).any()):
        found.append(Contact("palm", "palm", 0.0))
    if thumb.holds:
        found += _touching("thumb", _LINKS if hand.robot else _THUMB_LINKS, thumb.gap_m)
    for index, finger in enumerate(FINGERS):
        found += _touching(finger, _LINKS, fingers.gap_m[index])
    return tuple(found)


def _touching(digit: str, links: tuple[str, ...], gap_m: Float64) -> list[Contact]:
    return [
        Contact(digit, link, float(gap))
        for link, gap in zip(links, gap_m, strict=True)
        if abs(gap) <= CONTACT_M
    ]


def _thumb_warnings(hand: GraspHand, grip: str, method: str, thumb: Thumb) -> tuple[str, ...]:
    rule = APERTURE_RAD[grip]
    if method == "thesis" and hand.robot is not None:
        return ("the thumb lies tangent in its own plane: chapter 5 does not say how it meets the object",)
    if thumb.gap_m.min() < -CONTACT_M:
        return (
            f"the thumb cannot clear a long object and is left out: its base stands where the object passes "
            f"({-1e3 * float(thumb.gap_m.min()):.0f} mm deep), so the object must end before it",
        )
    if not thumb.holds:
        return ("the thumb does not reach the object in this grip",)
    if hand.robot is None and abs(thumb.aperture_rad - rule) > math.radians(0.5):
        return (
            f"the aperture is {math.degrees(thumb.aperture_rad):.1f} deg: at the "
            f"{math.degrees(rule):.1f} deg that people keep around 60 mm the thumb does not touch this",
        )
    return ()
