"""What shape a hand has, as chapter 3 of the thesis measures it: pure functions over the 25 landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rehab_app.grasp.curvature import joint_curvature_per_m
from sessions.errors import Refused
from sessions.records import LANDMARKS, Side
from sessions.records.fields import Float64
from sessions.records.names import DIGITS, FINGERS

NEIGHBOURS: tuple[str, ...] = tuple(f"{one}_{other}" for one, other in pairwise(FINGERS))
"""The three pairs of neighbouring fingers."""

_NO_LENGTH_M = 1e-9  # a link shorter than this has no direction
_PIPS = [LANDMARKS.index(f"{finger}_pip") for finger in FINGERS]
_MCPS = [LANDMARKS.index(f"{finger}_mcp") for finger in FINGERS]


@dataclass(frozen=True, slots=True)
class HandShape:
    """The shape of a hand in N frames; NaN where a landmark that it needs is.

    Attributes:
        aperture_rad: Angle at the wrist between the knuckles of thumb and index finger, shape (N,).
        curvature_per_m: Curvature of each digit at its four landmarks, from the palm to the tip, shape
            (N, 5, 4), digits in the order of DIGITS. The first and the last are 0: a natural spline ends so.
        pip_distance_m: Distance of neighbouring fingers' middle joints, shape (N, 3), order of NEIGHBOURS.
        abduction_rad: Angle that this distance subtends, shape (N, 3); see ``abduction_rad``.
        opposition_rad: The thumb's two parts, shape (N, 2); see ``opposition_rad``.
    """

    aperture_rad: Float64
    curvature_per_m: Float64
    pip_distance_m: Float64
    abduction_rad: Float64
    opposition_rad: Float64

    @property
    def radius_m(self) -> Float64:
        """Radius of curvature at the two inner joints, shape (N, 5, 2), m; infinite where straight."""
        with np.errstate(divide="ignore"):
            radius: Float64 = 1.0 / self.curvature_per_m[..., 1:3]
        return radius


def hand_shape(landmarks_palm_m: Float64, side: Side) -> HandShape:
    """All measures of a hand.

    Args:
        landmarks_palm_m: Landmarks in the palm frame (x palmar, z distal), order of LANDMARKS, (N, 25, 3).
        side: Side of the hand.

    Raises:
        Refused: The array has another shape.
    """
    if landmarks_palm_m.ndim != 3 or landmarks_palm_m.shape[1:] != (len(LANDMARKS), 3):
        raise Refused(
            "landmarks",
            f"of shape {landmarks_palm_m.shape}",
            f"(frames, {len(LANDMARKS)}, 3)",
            "give all landmarks in their order",
        )
    return HandShape(
        aperture_rad(landmarks_palm_m),
        curvature_per_m(landmarks_palm_m),
        pip_distance_m(landmarks_palm_m),
        abduction_rad(landmarks_palm_m),
        opposition_rad(landmarks_palm_m, side),
    )


def aperture_rad(landmarks_m: Float64) -> Float64:
    """Angle at the wrist between thumb MCP and index MCP, in any frame.

    Args:
        landmarks_m: Shape (N, 25, 3).

    Returns:
        Shape (N,), 0 to pi.
    """
    wrist = _at(landmarks_m, "wrist")
    one, other = _at(landmarks_m, "thumb_mcp") - wrist, _at(landmarks_m, "index_mcp") - wrist
    across = np.linalg.norm(np.cross(one, other), axis=-1)
    known = np.minimum(np.linalg.norm(one, axis=-1), np.linalg.norm(other, axis=-1)) > _NO_LENGTH_M
    angle: Float64 = np.where(known, np.arctan2(across, (one * other).sum(axis=-1)), np.nan)
    return angle


def curvature_per_m(landmarks_m: Float64) -> Float64:
    """Curvature of every digit at its four landmarks, in any frame.

    Args:
        landmarks_m: Shape (N, 25, 3).

    Returns:
        Shape (N, 5, 4), 1/m; NaN throughout a digit of which a landmark is missing or falls on the next.
    """
    digits = landmarks_m[:, : 4 * len(DIGITS)].reshape(len(landmarks_m), len(DIGITS), 4, 3)
    bones = np.linalg.norm(np.diff(digits, axis=2), axis=3)
    known = (bones > _NO_LENGTH_M).all(axis=2)
    curvature = np.full(digits.shape[:3], np.nan)
    curvature[known] = joint_curvature_per_m(digits[known])
    return curvature


def pip_distance_m(landmarks_m: Float64) -> Float64:
    """Distance of neighbouring fingers' middle joints, shape (N, 3), m, in any frame."""
    distance: Float64 = np.linalg.norm(np.diff(landmarks_m[:, _PIPS], axis=1), axis=2)
    return distance


def abduction_rad(landmarks_m: Float64) -> Float64:
    """Angle between neighbouring fingers, as the distance of their middle joints subtends it, in any frame.

    The thesis names neither apex nor sides. Here they are those of the triangle with the two proximal bones
    for sides and the PIP distance opposite: parallel fingers give the angle of their spacing, not 0, so what
    counts is its change from rest.

    Args:
        landmarks_m: Shape (N, 25, 3).

    Returns:
        Shape (N, 3), order of NEIGHBOURS; NaN where no such triangle exists.
    """
    bone = np.linalg.norm(landmarks_m[:, _PIPS] - landmarks_m[:, _MCPS], axis=2)
    one, other, opposite = bone[:, :-1], bone[:, 1:], pip_distance_m(landmarks_m)
    known = (np.minimum(one, other) > _NO_LENGTH_M) & (opposite <= one + other)
    known &= opposite >= np.abs(one - other)
    cosine = np.full(opposite.shape, np.nan)
    product = 2.0 * one * other
    np.divide(one**2 + other**2 - opposite**2, product, out=cosine, where=known)
    angle: Float64 = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angle


def opposition_rad(landmarks_palm_m: Float64, side: Side) -> Float64:
    """The two parts of the thumb's opposition.

    Args:
        landmarks_palm_m: Landmarks in the palm frame, shape (N, 25, 3).
        side: Side of the hand; a left hand gives the angles of its mirror image.

    Returns:
        Shape (N, 2): from the palmar axis to the projection onto the palmar-radial plane of the line from the
        index finger's MCP to the thumb's CMC, positive to radial, -pi to pi; and from the distal axis to the
        thumb's metacarpal, 0 to pi/2. NaN where a line has no direction.
    """
    line = _at(landmarks_palm_m, "thumb_cmc") - _at(landmarks_palm_m, "index_mcp")
    radial = line[:, 1] if side == "right" else -line[:, 1]
    known = np.hypot(line[:, 0], radial) > _NO_LENGTH_M
    around = np.where(known, np.arctan2(radial, line[:, 0]), np.nan)
    bone = _at(landmarks_palm_m, "thumb_mcp") - _at(landmarks_palm_m, "thumb_cmc")
    known = np.linalg.norm(bone, axis=1) > _NO_LENGTH_M
    from_axis = np.arctan2(np.hypot(bone[:, 0], bone[:, 1]), np.abs(bone[:, 2]))
    return np.stack([around, np.where(known, from_axis, np.nan)], axis=1)


def _at(landmarks_m: Float64, name: str) -> Float64:
    return landmarks_m[:, LANDMARKS.index(name)]
