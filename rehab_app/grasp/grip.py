"""The long fingers of a grip, by either method, in the object's frame; and what stops a method."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.closing import FingerClosing
from rehab_app.grasp.contact import Held, hold, search
from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.newton import TangentObjective
from rehab_app.grasp.objects import Cylinder, Sphere, Thing
from rehab_app.grasp.tangent import Tangent, heights_m, tangent
from sessions.records import FINGERS
from sessions.records.fields import Float64

GRIPS = ("transverse", "diagonal")
STEEPEST_RAD = math.radians(60.0)
"""Largest inclination that can be asked for, rad."""

# Inclinations in which each grip is searched, and the fingers against whose palm the object must lie. In the
# transverse grip it crosses the whole row of knuckles; in the diagonal one it runs from the index finger to
# the heel of the hand: towards the fingertips on the thumb's side, which is a negative alpha.
_ALPHA_RAD = {
    "transverse": (math.radians(-15.0), math.radians(15.0)),
    "diagonal": (math.radians(-45.0), math.radians(-15.0)),
}
_IN_PALM = {"transverse": (0, 1, 2, 3), "diagonal": (2, 3)}
_Z_PARTS = (-0.10, 0.35)  # of wrist to middle fingertip


@dataclass(frozen=True, slots=True)
class Fingers:
    """Four fingers around an object.

    Attributes:
        z_m: Height of the little finger's knuckle over the object's axis.
        alpha_rad: Inclination of the object.
        objective_m: Sum of the distances of MCP, PIP and DIP joints from the surface.
        mcp_rad: Flexion of the knuckles, shape (4,).
        pip_rad: Flexion of the middle joints, shape (4,).
        points_m: Joints and tips in the object's frame, shape (4, 4, 3).
        gap_m: From each link's surface to the object's, shape (4, 3); negative is penetration.
        warnings: What is not as the method's drawing shows it.
    """

    z_m: float
    alpha_rad: float
    objective_m: float
    mcp_rad: Float64
    pip_rad: Float64
    points_m: Float64
    gap_m: Float64
    warnings: tuple[str, ...]


def contact_fingers(hand: GraspHand, thing: Thing, grip: str, alpha_rad: float | None) -> Fingers:
    """Fingers closed to contact in the best place of all.

    Raises:
        Refused: The object cannot be held so; the value says why.
    """
    closing = FingerClosing(hand, thing)
    span = _Z_PARTS[0] * _reach_m(hand), _Z_PARTS[1] * _reach_m(hand)
    alphas = _ALPHA_RAD[grip] if alpha_rad is None else (alpha_rad, alpha_rad)
    in_palm = _IN_PALM[grip]
    if isinstance(thing, Sphere):
        alphas, in_palm = (0.0, 0.0), _IN_PALM["transverse"]  # a ball has no axis to incline
    elif alphas[0] < _ALPHA_RAD["transverse"][0]:
        in_palm = _IN_PALM["diagonal"]  # an object asked to lie that steeply leaves the index finger's palm
    held = search(closing, span, alphas, in_palm)
    if not math.isfinite(held.objective_m):
        raise Refused(
            "grip",
            f"not possible: {_why_not(closing, alphas[0])}",
            "a posture inside every joint's range",
            "choose another size",
        )
    closed = held.closed
    return Fingers(
        held.z_m,
        held.alpha_rad,
        held.objective_m,
        closed.mcp_rad[0],
        closed.pip_rad[0],
        closed.points_m[0],
        closed.gap_m[0],
        _edge_warning(held, grip, alphas),
    )


def thesis_fingers(hand: GraspHand, thing: Thing, alpha_rad: float | None) -> Fingers:
    """Fingers tangent to a cylinder at the optimum of eq. 5.1.

    Raises:
        Refused: The object is no cylinder, a link cannot be tangent, or a joint's range ends before.
    """
    if not isinstance(thing, Cylinder):
        raise Refused("object", "no cylinder", "a cylinder for method thesis", "use method contact")
    best = TangentObjective(hand).minimum(thing.radius_m, alpha_rad)
    u = heights_m(hand, best.z_m, best.alpha_rad)
    touch = tangent(u, thing.radius_m, hand.links_m, hand.palm_half_m, hand.half_m)
    _check_tangent(hand, touch)
    points = tangent_points_m(hand, thing.radius_m, u, touch)
    gap = thing.distance_m(points[:, :-1], points[:, 1:]) - hand.half_m
    return Fingers(
        best.z_m,
        best.alpha_rad,
        best.objective_m,
        touch.mcp_rad,
        touch.pip_rad,
        points,
        gap,
        _tangent_warnings(hand, touch, gap),
    )


def tangent_points_m(hand: GraspHand, radius_m: float, u_m: Float64, touch: Tangent) -> Float64:
    """Joints and tips of tangent fingers in their planes, shape (4, 4, 3): depth, across, nought."""
    flexion = np.stack(
        [
            touch.mcp_rad,
            touch.mcp_rad + touch.pip_rad,
            touch.mcp_rad + (1 + hand.dip_per_pip) * touch.pip_rad,
        ],
        axis=-1,
    )
    points = np.zeros((len(u_m), 4, 3))
    points[:, 0, 0], points[:, 0, 1] = -(radius_m + hand.palm_half_m), u_m
    steps = np.stack([np.sin(flexion), np.cos(flexion)], axis=-1) * hand.links_m[..., None]
    points[:, 1:, :2] = points[:, :1, :2] + np.cumsum(steps, axis=1)
    return points


def _reach_m(hand: GraspHand) -> float:
    return float(hand.knuckles_m[1, 2] + hand.links_m[1].sum())


def _why_not(closing: FingerClosing, alpha_rad: float) -> str:
    """What fails where the object lies in the palm right below the knuckles."""
    lowest_m = float(closing.heights_m(np.zeros(1), np.array([alpha_rad])).min())
    why = hold(closing, max(0.0, -lowest_m / math.cos(alpha_rad)), alpha_rad).why
    return why[0] if why else "no place in the palm lets all fingers touch it"


def _edge_warning(held: Held, grip: str, alphas: tuple[float, float]) -> tuple[str, ...]:
    edge = min(abs(held.alpha_rad - alphas[0]), abs(held.alpha_rad - alphas[1]))
    if alphas[0] == alphas[1] or edge > 1e-3:
        return ()
    return (
        f"the inclination lies at the end of what counts as {grip}: {math.degrees(held.alpha_rad):.1f} deg",
    )


def _check_tangent(hand: GraspHand, touch: Tangent) -> None:
    for index, finger in enumerate(FINGERS):
        mcp, pip = float(touch.mcp_rad[index]), float(touch.pip_rad[index])
        if not math.isfinite(mcp + pip):
            raise Refused(f"{finger} link", "inside the object", "tangent to it", "choose another radius")
        lies_m, link_m = float(touch.contact_m[index, 0]), float(hand.links_m[index, 0])
        if lies_m > link_m:
            raise Refused(
                f"{finger} contact",
                f"{lies_m:.4g} m along its proximal link",
                f"at most {link_m:.4g} m",
                "choose a smaller radius",
            )
        for joint, angle, limit in (("MCP", mcp, hand.mcp_max_rad), ("PIP", pip, hand.pip_max_rad)):
            if not 0.0 <= angle <= limit:
                raise Refused(
                    f"{finger} {joint} angle",
                    f"{angle:.4g} rad",
                    f"0 to {limit:.4g} rad",
                    "choose another radius or inclination",
                )


def _tangent_warnings(hand: GraspHand, touch: Tangent, gap_m: Float64) -> tuple[str, ...]:
    said = [
        f"the {finger} finger's medial link ends {1e3 * float(beyond):.1f} mm before its tangent point"
        for finger, beyond in zip(FINGERS, touch.contact_m[:, 1] - hand.links_m[:, 1], strict=True)
        if beyond > 0
    ]
    deepest = -float(gap_m.min())
    if deepest > 1e-5:
        finger, link = divmod(int(np.argmin(gap_m)), 3)
        name = ("proximal", "medial", "distal")[link]
        said.append(
            f"the {FINGERS[finger]} finger's {name} link cuts {1e3 * deepest:.1f} mm into the object "
            "(the tangent posture of the thesis; method contact does not)"
        )
    return tuple(said)
