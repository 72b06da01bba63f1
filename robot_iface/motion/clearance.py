"""Distance between the skins of thumb, fingers and palm along a movement.

A hand is seen as capsules: a bone with a radius of flesh. What is looked for is what a device must not do to
a hand that may not feel it: clench the fingers over the thumb, press thumb and finger together, or drive a
nail into the palm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot_iface.kinematics import HandFrames, HandGeometry, couple_dip, forward
from robot_iface.types import FINGERS, JOINTS, Float64, joint_index

CLEARANCE_M = 0.005
"""Least distance between skins while a device moves the hand (clinical.md)."""
_HAND_M = 0.189
_THUMB_RADII_M = (0.010, 0.0085)
_FINGER_RADII_M = (0.009, 0.008, 0.0065)
_PALM_RADIUS_M = 0.014
"""Half of the breadth of an average digit of a 189 mm hand at mid-bone (20 and 17 mm; 18, 16 and 13 mm), and
the flesh of the palm before the metacarpals: assumed after hand anthropometry, scaled with length."""
_FINGER_HALF_BREADTH_M = 0.008
_TINY = 1e-12


@dataclass(frozen=True, slots=True)
class Closeness:
    """The first place where a movement comes too close.

    Attributes:
        between: "thumb to index", "index tip to palm"; "thumb under index" where the distance is not the
            matter, but the order of closing.
        place: Index of the posture.
        value_m: Distance between skins; NaN for the order.
    """

    between: str
    place: int
    value_m: float


def whole_hand(driven_rad: Float64, joint_names: tuple[str, ...]) -> Float64:
    """The 21 angles (N, 21) of a hand of which only some are driven, (N, J).

    DIP joints follow their PIP joints unless they are driven themselves; the rest stay straight.
    """
    joints = np.zeros((len(driven_rad), len(JOINTS)))
    joints[:, joint_index(joint_names)] = driven_rad
    coupled = couple_dip(joints)
    dips = [name for name in joint_names if name.endswith("_dip")]
    if dips:
        coupled[:, joint_index(tuple(dips))] = joints[:, joint_index(tuple(dips))]
    return coupled


def too_close(geometry: HandGeometry, joints_rad: Float64, bound_m: float = CLEARANCE_M) -> Closeness | None:
    """The first posture in which skins come closer than a bound, or the thumb gets under a finger.

    Three rules: the thumb's two free bones keep the bound to every bone of every finger; every fingertip's
    bone keeps it to the palm; and the thumb closes last, so that its bones never cross the area that a finger
    encloses with the palm (MCP, PIP, DIP, tip and the point of the palm below the tip).

    Args:
        geometry: The hand.
        joints_rad: Postures in the order of JOINTS, (N, 21).
        bound_m: Least distance.

    Returns:
        The earliest; at one instant, the least distance before the order.
    """
    frames = forward(geometry, joints_rad)
    points = frames.landmarks_m[:, :20].reshape(len(joints_rad), 5, 4, 3)
    names, distances = _distances(points, geometry)
    under = np.stack([_thumb_under(frames, points, finger) for finger in range(1, 5)], axis=1)
    close: NDArray[np.bool_] = np.any(distances < bound_m, axis=1)
    bad: NDArray[np.bool_] = close | np.any(under, axis=1)
    if not bool(bad.any()):
        return None
    place = int(np.argmax(bad))
    if close[place]:
        worst = int(np.argmin(distances[place]))
        return Closeness(names[worst], place, float(distances[place, worst]))
    return Closeness(f"thumb under {FINGERS[int(np.argmax(under[place]))]}", place, float("nan"))


def least_clearance_m(geometry: HandGeometry, joints_rad: Float64) -> dict[str, float]:
    """Least distance between skins over all postures, (N, 21), by pair: see ``too_close``."""
    points = forward(geometry, joints_rad).landmarks_m[:, :20].reshape(len(joints_rad), 5, 4, 3)
    names, distances = _distances(points, geometry)
    return dict(zip(names, distances.min(axis=0).tolist(), strict=True))


def _distances(points: Float64, geometry: HandGeometry) -> tuple[tuple[str, ...], Float64]:
    """Distances between skins, (N, 8): thumb to each finger, each fingertip to the palm."""
    scale = geometry.length_m / _HAND_M
    names = (*(f"thumb to {name}" for name in FINGERS), *(f"{name} tip to palm" for name in FINGERS))
    columns = [_thumb_to(points, finger, scale) for finger in range(1, 5)]
    columns += [_tip_to_palm(points, geometry, finger, scale) for finger in range(1, 5)]
    return names, np.stack(columns, axis=1)


def _thumb_to(points: Float64, finger: int, scale: float) -> Float64:
    """Least distance of the thumb's proximal and distal bone to a finger's three, (N,)."""
    least = np.full(len(points), np.inf)
    for bone, radius in enumerate(_THUMB_RADII_M, start=1):
        for other, other_radius in enumerate(_FINGER_RADII_M):
            gap = _segment_distance(
                *(points[:, 0, bone], points[:, 0, bone + 1]),
                *(points[:, finger, other], points[:, finger, other + 1]),
            )
            least = np.minimum(least, gap - (radius + other_radius) * scale)
    return least


def _tip_to_palm(points: Float64, geometry: HandGeometry, finger: int, scale: float) -> Float64:
    """Least distance of a finger's distal bone to the flesh before the four metacarpals, (N,)."""
    least = np.full(len(points), np.inf)
    wrist = np.broadcast_to(geometry.palm_m[0] * geometry.mirror, (len(points), 3))
    for metacarpal in range(1, 5):
        gap = _segment_distance(points[:, finger, 2], points[:, finger, 3], wrist, points[:, metacarpal, 0])
        least = np.minimum(least, gap - (_PALM_RADIUS_M + _FINGER_RADII_M[2]) * scale)
    return least


def _thumb_under(frames: HandFrames, points: Float64, finger: int) -> NDArray[np.bool_]:
    """Whether a free bone of the thumb crosses the area between a finger and the palm, (N,)."""
    normal = frames.rotations[:, finger, 0, :, 1]
    palmar = np.array([1.0, 0.0, 0.0]) - normal * normal[:, :1]
    palmar /= np.linalg.norm(palmar, axis=1, keepdims=True)
    distal = np.cross(palmar, normal)
    distal *= np.where(distal[:, 2:] < 0.0, -1.0, 1.0)
    origin = points[:, finger, :1]
    chain = points[:, finger] - origin
    area = np.stack([_dot(chain, palmar), _dot(chain, distal)], axis=2)
    foot = np.stack([np.zeros(len(points)), np.minimum(area[:, 3, 1], 0.0)], axis=1)
    area = np.concatenate([area, foot[:, None]], axis=1)
    thumb = points[:, 0, 1:] - origin
    height = _dot(thumb, normal)
    flat = np.stack([_dot(thumb, palmar), _dot(thumb, distal)], axis=2)
    crossed = np.zeros(len(points), dtype=np.bool_)
    for bone in range(2):
        low, high = height[:, bone], height[:, bone + 1]
        share = np.clip(low / (low - high + np.where(low == high, _TINY, 0.0)), 0.0, 1.0)
        place = flat[:, bone] + share[:, None] * (flat[:, bone + 1] - flat[:, bone])
        reaches = np.minimum(np.abs(low), np.abs(high)) < _FINGER_HALF_BREADTH_M
        crossed |= ((low * high <= 0.0) | reaches) & _inside(area, place)
    return crossed


def _dot(vectors: Float64, axis: Float64) -> Float64:
    """(N, M, 3) by (N, 3) -> (N, M)."""
    product: Float64 = np.einsum("nmd,nd->nm", vectors, axis)
    return product


def _inside(corners: Float64, places: Float64) -> NDArray[np.bool_]:
    """Whether places, (N, 2), lie in polygons, (N, K, 2), by the even-odd rule."""
    inside = np.zeros(len(places), dtype=np.bool_)
    x, y = places.T
    for here in range(corners.shape[1]):
        ax, ay = corners[:, here].T
        bx, by = corners[:, here - 1].T
        spans = (ay > y) != (by > y)
        rise = np.where(spans, by - ay, 1.0)
        inside ^= spans & (x < ax + (y - ay) * (bx - ax) / rise)
    return inside


def _segment_distance(a: Float64, b: Float64, c: Float64, d: Float64) -> Float64:
    """Distance of the segments a-b and c-d, each (N, 3) -> (N,) (Ericson 2005, section 5.1.9)."""
    u, v, w = b - a, d - c, a - c
    uu, vv = (u * u).sum(1) + _TINY, (v * v).sum(1) + _TINY
    uv, uw, vw = (u * v).sum(1), (u * w).sum(1), (v * w).sum(1)
    s = np.clip((uv * vw - uw * vv) / (uu * vv - uv * uv + _TINY), 0.0, 1.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    distance: Float64 = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)
    return distance
