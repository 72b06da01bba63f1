"""Outlines as line segments: a hand of rings and lengthwise lines, the edges of what it holds."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from rehab_app.grasp.objects import Box, Sphere, Thing
from rehab_app.services.grip_target import GripTarget
from rehab_app.web.viewport.hand_shape import HandShape
from robot_iface.kinematics import HandGeometry, forward
from robot_iface.types import Float64

_AROUND = 24
_LENGTHWISE = 6
_TAPER = 0.87
_LOOSE = 1.06  # an outline stands a little off: at the target the hand itself would hide it
_BEYOND_M = 0.012  # long things count as longer than the hand is broad: drawn so far beyond its digits


def hand_lines_m(geometry: HandGeometry, joints_rad: Float64) -> Float64:
    """The digits of a hand as lines in the palm frame, shape (N, 2, 3).

    Args:
        geometry: The hand.
        joints_rad: Its posture, shape (21,).
    """
    shape = HandShape(geometry)
    segments, balls = shape.pose(joints_rad)
    bones = _placed(_bone(), shape.segment_scales_m, segments.p_palm_m, segments.q_palm_wxyz)
    tips = np.arange(3, 20, 4)
    caps = _placed(_cap(), shape.ball_scales_m[tips], balls.p_palm_m[tips], balls.q_palm_wxyz[tips])
    return np.concatenate([bones, caps])


def thing_place(target: GripTarget) -> tuple[Float64, Float64]:
    """Drawn middle of the object in the palm frame (3,), and its size out of the palm, across, along (3,)."""
    thing: Thing = target.choice.thing
    if isinstance(thing, Sphere):
        return target.p_palm_object_m, np.full(3, 2 * thing.radius_m)
    digits_m = forward(target.geometry, target.joints_rad).landmarks_m[:20] - target.p_palm_object_m
    along_m = digits_m @ target.r_palm_object[:, 2]
    low, high = float(along_m.min()) - _BEYOND_M, float(along_m.max()) + _BEYOND_M
    middle = target.p_palm_object_m + target.r_palm_object[:, 2] * (low + high) / 2
    across = (thing.depth_m, thing.width_m) if isinstance(thing, Box) else (2 * thing.radius_m,) * 2
    return middle, np.array([*across, high - low])


def thing_lines_m(target: GripTarget) -> Float64:
    """The edges of the object in the palm frame, shape (N, 2, 3)."""
    thing = target.choice.thing
    if isinstance(thing, Box):
        unit = _block()
    else:
        unit = np.concatenate([_ring(0.5, z) for z in ((0.0,) if isinstance(thing, Sphere) else (-0.5, 0.5))])
    middle, size = thing_place(target)
    return (unit * size) @ target.r_palm_object.T + middle


def _bone() -> Float64:
    """Rings and lengthwise lines of a finger segment of unit radius and length, shape (N, 2, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, _LENGTHWISE, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(_LENGTHWISE)], axis=1)
    along = np.stack([circle, _TAPER * circle + [0.0, 0.0, 1.0]], axis=1)
    return np.concatenate([_ring(1.0, 0.0), _ring(_TAPER, 1.0), along])


def _cap() -> Float64:
    """The round end of a finger of unit radius: lines of longitude, shape (N, 2, 3)."""
    polar = np.linspace(0.0, np.pi, _AROUND // 2 + 1)
    lines: list[Float64] = []
    for angle in np.linspace(0.0, np.pi, _LENGTHWISE // 2, endpoint=False):
        arc = np.stack([np.cos(polar) * np.cos(angle), np.cos(polar) * np.sin(angle), np.sin(polar)], axis=1)
        lines.append(np.stack([arc[:-1], arc[1:]], axis=1))
    return np.concatenate(lines)


def _ring(radius: float, height: float) -> Float64:
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(_AROUND + 1, height)], axis=1)
    return np.stack([points[:-1], points[1:]], axis=1)


def _block() -> Float64:
    """The twelve edges of a cube of edge 1, shape (12, 2, 3)."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    pairs = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]
    return np.array([[corners[a], corners[b]] for a, b in pairs])


def _placed(unit: Float64, scales_m: Float64, p_palm_m: Float64, q_palm_wxyz: Float64) -> Float64:
    """Copies of unit lines (L, 2, 3) at places (N, 3), sizes (N, 3) and rotations (N, 4): (N * L, 2, 3)."""
    loose = scales_m * np.array([_LOOSE, _LOOSE, 1.0])
    turned = Rotation.from_quat(q_palm_wxyz, scalar_first=True).as_matrix()
    lines = np.einsum("nij,nlej->nlei", turned, unit * loose[:, None, None])
    return np.asarray(lines + p_palm_m[:, None, None], dtype=np.float64).reshape(-1, 2, 3)
