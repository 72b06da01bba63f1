"""Closing fingers until they touch: the knuckle first, then the coupled middle and distal joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.objects import Thing
from sessions.records.fields import Float64

Bool = npt.NDArray[np.bool_]

_SAMPLES = 20
CONTACT_M = 1e-5
"""Nearer than this counts as touching, m."""


@dataclass(frozen=True, slots=True)
class Closed:
    """Four fingers closed around an object in B places; the object's frame.

    Attributes:
        mcp_rad: Flexion of the knuckles, shape (B, 4).
        pip_rad: Flexion of the middle joints, shape (B, 4).
        points_m: Knuckle, PIP, DIP, tip, shape (B, 4, 4, 3).
        gap_m: From each link's surface to the object's, shape (B, 4, 3); negative is penetration.
        met: Whether a link stopped each of the two movements, shape (B, 4, 2).
    """

    mcp_rad: Float64
    pip_rad: Float64
    points_m: Float64
    gap_m: Float64
    met: Bool


class FingerClosing:
    """Closes the four long fingers of one hand around one object that touches the palm.

    Args:
        hand: The hand.
        thing: The object.
    """

    def __init__(self, hand: GraspHand, thing: Thing) -> None:
        self._hand = hand
        self._thing = thing

    def heights_m(self, z_m: Float64, alpha_rad: Float64) -> Float64:
        """Height of the knuckles over the object's axis, seen along it, shape (B, 4), for places (B,)."""
        return in_object_frame(self._hand, self._thing, z_m, alpha_rad, self._hand.knuckles_m)[..., 1]

    def close(self, z_m: Float64, alpha_rad: Float64, halvings: int) -> Closed:
        """The fingers at first contact.

        Each movement is sampled and its first sample inside the object is closed in on from outside, so that
        no link ends in the object.

        Args:
            z_m: Height of the little finger's knuckle over the object's axis, shape (B,).
            alpha_rad: Inclination of the object, shape (B,).
            halvings: How finely: each halves about 5 degrees.
        """
        knuckles = in_object_frame(self._hand, self._thing, z_m, alpha_rad, self._hand.knuckles_m)
        tilt = np.stack([np.cos(alpha_rad), -np.sin(alpha_rad)], axis=-1)[:, None]
        zero = np.zeros(knuckles.shape[:-1])

        def whole(mcp: Float64) -> Float64:
            return self._gap(self._points(knuckles, tilt, mcp, zero)).min(axis=-1)

        mcp, met_mcp = first_contact(whole, zero, self._hand.mcp_max_rad, halvings)

        def outer(pip: Float64) -> Float64:
            return self._gap(self._points(knuckles, tilt, mcp, pip))[..., 1:].min(axis=-1)

        pip, met_pip = first_contact(outer, zero, self._hand.pip_max_rad, halvings)
        points = self._points(knuckles, tilt, mcp, pip)
        return Closed(mcp, pip, points, self._gap(points), np.stack([met_mcp, met_pip], axis=-1))

    def joint_distance_m(self, points_m: Float64) -> Float64:
        """Distance of MCP, PIP and DIP joints from the surface, shape (..., 3), m."""
        joints = points_m[..., :3, :]
        return self._thing.distance_m(joints, joints)

    def _points(self, knuckles: Float64, tilt: Float64, mcp: Float64, pip: Float64) -> Float64:
        flexion = np.stack([mcp, mcp + pip, mcp + (1.0 + self._hand.dip_per_pip) * pip], axis=-1)
        distal = self._hand.links_m * np.cos(flexion)
        steps = np.stack(
            [self._hand.links_m * np.sin(flexion), distal * tilt[..., :1], distal * tilt[..., 1:]], axis=-1
        )
        points = np.empty((*mcp.shape, 4, 3))
        points[..., 0, :] = knuckles
        points[..., 1:, :] = knuckles[..., None, :] + np.cumsum(steps, axis=-2)
        return points

    def _gap(self, points_m: Float64) -> Float64:
        return self._thing.distance_m(points_m[..., :-1, :], points_m[..., 1:, :]) - self._hand.half_m


def in_object_frame(
    hand: GraspHand, thing: Thing, z_m: Float64, alpha_rad: Float64, points_m: Float64
) -> Float64:
    """Points of the palm frame (right-hand form) in the frame of an object that touches the palm.

    Args:
        hand: The hand.
        thing: The object; its middle lies between the knuckles.
        z_m: Height of the little finger's knuckle over the object's axis, shape (B,).
        alpha_rad: Inclination of the object's axis against the row of knuckles, shape (B,).
        points_m: Points, shape (N, 3) or (B, N, 3).

    Returns:
        Depth, across and along, shape (B, N, 3), m.
    """
    cosine, sine = np.cos(alpha_rad)[:, None], np.sin(alpha_rad)[:, None]
    knuckles = hand.knuckles_m
    middle_y = knuckles[:, 1].mean() - knuckles[3, 1]
    middle_z = knuckles[:, 2].mean() - knuckles[3, 2]
    lateral = points_m[..., 1] - knuckles[3, 1]
    distal = points_m[..., 2] - knuckles[3, 2] + z_m[:, None]
    across = distal * cosine + lateral * sine
    along = (lateral - middle_y) * cosine - (distal - middle_z - z_m[:, None]) * sine
    depth = np.broadcast_to(points_m[..., 0] - hand.palm_half_m - thing.half_depth_m, across.shape)
    return np.stack([depth, across, along], axis=-1)


def first_contact(
    gap: Callable[[Float64], Float64], like: Float64, largest_rad: float, halvings: int
) -> tuple[Float64, Bool]:
    """Angle at first contact seen from 0, on the free side, and whether there is one; shape of ``like``."""
    samples = np.linspace(0.0, largest_rad, _SAMPLES)
    inside = np.stack([gap(np.full_like(like, angle)) <= 0.0 for angle in samples])
    met: Bool = np.logical_or.reduce(inside, axis=0)
    first = np.argmax(inside, axis=0)
    low = np.where(met, samples[np.maximum(first - 1, 0)], largest_rad)
    high = np.where(met, samples[first], largest_rad)
    for _ in range(halvings):
        middle = (low + high) / 2
        free = gap(middle) > 0.0
        low, high = np.where(free, middle, low), np.where(free, high, middle)
    return low, met
