"""Coupled ranges: the convex sets that two joints may share, packed for the compiled kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.errors import Refused
from robot_iface.safety.hull_kernels import distance_outside, nearest_in
from robot_iface.types import Float64, Hull, Int64, Limits

_SMALLEST_EDGE_RAD = 1e-9


@dataclass(frozen=True, slots=True)
class PackedHulls:
    """All hulls of a device.

    Attributes:
        pairs: One row a hull: first joint, second joint, first corner, corner after the last, (H, 4).
        corners_rad: Corners of all hulls in a row, each hull counter-clockwise, (C, 2).
        names: Both joints' names as a person reads them, one a hull.
    """

    pairs: Int64
    corners_rad: Float64
    names: tuple[str, ...]

    def outside(self, q_rad: Float64, margin_rad: float) -> str:
        """Names of the first pair of joints that is outside its hull by more than a margin, or empty."""
        for name, (first, second, start, stop) in zip(self.names, self.pairs.tolist(), strict=True):
            place = float(q_rad[first]), float(q_rad[second])
            if not distance_outside(*place, self.corners_rad, start, stop) <= margin_rad:
                return name
        return ""

    def pulled_in(self, q_rad: Float64) -> Float64:
        """The posture with every pair moved to the nearest point of its hull, (J,)."""
        pulled = q_rad.copy()
        for first, second, start, stop in self.pairs.tolist():
            place = float(pulled[first]), float(pulled[second])
            pulled[first], pulled[second] = nearest_in(*place, self.corners_rad, start, stop)
        return pulled


def pack_hulls(limits: Limits, joint_names: tuple[str, ...]) -> PackedHulls:
    """The hulls of some limits, each cut to the box of its two joints.

    Args:
        limits: Limits of the driven joints.
        joint_names: Their names.

    Raises:
        Refused: A hull names a joint that is not driven, one joint is in two hulls, or nothing of a hull lies
            within the box.
    """
    pairs: list[tuple[int, int, int, int]] = []
    corners: list[Float64] = [np.zeros((0, 2))]
    names: list[str] = []
    taken: set[str] = set()
    start = 0
    for hull in limits.hulls:
        name = " and ".join(hull.joints)
        _check_joints(hull, joint_names, taken)
        first, second = (joint_names.index(joint) for joint in hull.joints)
        cut = _cut_to_box(hull, limits, (first, second))
        if len(cut) < 3:
            raise Refused(f"hull of {name}", "outside today's range", "inside it", "measure it again")
        pairs.append((first, second, start, start + len(cut)))
        corners.append(cut)
        names.append(name)
        start += len(cut)
    rows = np.array(pairs, dtype=np.int64).reshape(len(pairs), 4)
    return PackedHulls(rows, np.ascontiguousarray(np.concatenate(corners)), tuple(names))


def _check_joints(hull: Hull, joint_names: tuple[str, ...], taken: set[str]) -> None:
    for joint in hull.joints:
        if joint not in joint_names:
            bound = "one of " + ", ".join(joint_names)
            raise Refused("joint of a hull", joint, bound, "measure the range on this device")
        if joint in taken:
            raise Refused(f"joint {joint}", "in two hulls", "in one at most", "measure the range again")
        taken.add(joint)


def _cut_to_box(hull: Hull, limits: Limits, joints: tuple[int, int]) -> Float64:
    """Corners of the part of a hull that lies in the box of its joints, (K, 2); fewer than 3 for none."""
    corners = np.array(hull.corners_rad, dtype=np.float64)
    for axis, joint in enumerate(joints):
        corners = _cut(corners, axis, float(limits.q_min_rad[joint]), 1.0)
        corners = _cut(corners, axis, float(limits.q_max_rad[joint]), -1.0)
    apart = np.hypot(*(corners - np.roll(corners, 1, axis=0)).T) > _SMALLEST_EDGE_RAD
    return corners[apart]


def _cut(corners: Float64, axis: int, edge: float, sign: float) -> Float64:
    """The part of a convex polygon on one side of a line (Sutherland and Hodgman 1974)."""
    kept: list[Float64] = []
    depth = sign * (corners[:, axis] - edge)
    for index in range(len(corners)):
        before, here = float(depth[index - 1]), float(depth[index])
        if (before < 0.0) != (here < 0.0):
            share = before / (before - here)
            kept.append(corners[index - 1] + share * (corners[index] - corners[index - 1]))
        if here >= 0.0:
            kept.append(corners[index])
    return np.array(kept).reshape(len(kept), 2)
