"""The thesis's tangent posture (eqs. 5.1 to 5.6, repaired): centre distances, angles, and their derivatives.

Every link is taken as tangent to the object. With u the height of the knuckle over the object's axis, r the
radius, h_0 half the palm's thickness and h_k half a link's:

    D1 = sqrt(u^2 + (r+h0)^2)        T1 = sqrt(D1^2 - (r+h1)^2)
    D2 = sqrt((a1-T1)^2 + (r+h1)^2)  T2 = sqrt(D2^2 - (r+h2)^2)
    D3 = sqrt((a2-T2)^2 + (r+h2)^2)

As printed, the equations give centre distances and add the radius twice; here D - r is the distance from the
surface that eq. 5.1 sums.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rehab_app.grasp.hand import GraspHand
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class Tangent:
    """Tangent geometry of some fingers; arrays of one shape.

    Attributes:
        centre_m: Distance of MCP, PIP and DIP joint from the object's axis, shape (..., 3).
        contact_m: Where the links touch, from MCP and from PIP, shape (..., 2).
        mcp_rad: Flexion of the knuckle.
        pip_rad: Flexion of the middle joint.
    """

    centre_m: Float64
    contact_m: Float64
    mcp_rad: Float64
    pip_rad: Float64


def tangent(u_m: Float64, radius_m: float, links_m: Float64, palm_half_m: float, half_m: Float64) -> Tangent:
    """Distances and angles of fingers that lie tangent to a cylinder.

    Args:
        u_m: Height of each knuckle over the object's axis, shape (...).
        radius_m: Radius of the object.
        links_m: Lengths of the links, shape (..., 3).
        palm_half_m: Half thickness of the palm.
        half_m: Half thickness of the links, shape (..., 3).

    Returns:
        NaN where a root is negative: a link then lies farther from the axis than its own joint.
    """
    palm, first, second = radius_m + palm_half_m, radius_m + half_m[..., 0], radius_m + half_m[..., 1]
    with np.errstate(invalid="ignore"):
        d1 = np.sqrt(u_m**2 + palm**2)
        t1 = np.sqrt(d1**2 - first**2)
        rest = links_m[..., 0] - t1
        d2 = np.sqrt(rest**2 + first**2)
        t2 = np.sqrt(d2**2 - second**2)
        d3 = np.sqrt((links_m[..., 1] - t2) ** 2 + second**2)
        mcp = np.arctan2(palm, -u_m) - np.arctan2(first, t1)
        pip = np.pi - np.arctan2(first, rest) - np.arctan2(second, t2)
    return Tangent(np.stack([d1, d2, d3], axis=-1), np.stack([t1, t2], axis=-1), mcp, pip)


def distance_terms(
    u: Any, radius: Any, a1: Any, a2: Any, h: tuple[Any, Any, Any], sqrt: Callable[[Any], Any] = math.sqrt
) -> tuple[Any, Any, Any]:
    """D1 + D2 + D3 - 3 r of one finger with its first and second derivative by u, for numbers or arrays."""
    palm, r1, r2 = radius + h[0], radius + h[1], radius + h[2]
    r1s, r2s = r1 * r1, r2 * r2
    d1s = u * u + palm * palm
    t1s = d1s - r1s
    d1, t1 = sqrt(d1s), sqrt(t1s)
    # one division a root: the rest are products
    id1, it1 = 1.0 / d1, 1.0 / t1
    p1, q1 = u * id1, u * it1
    q1s = q1 * q1
    pp1, qq1 = (1.0 - p1 * p1) * id1, (1.0 - q1s) * it1
    e = a1 - t1
    d2s = e * e + r1s
    d2, t2 = sqrt(d2s), sqrt(d2s - r2s)
    id2, it2 = 1.0 / d2, 1.0 / t2
    slope, bend = e * q1, q1s - e * qq1  # of -d2 d2' and d2 d2'' + d2'^2
    p2, q2 = slope * id2, slope * it2
    pp2, q2s = (bend - p2 * p2) * id2, q2 * q2
    k = a2 - t2
    d3 = sqrt(k * k + r2s)
    id3 = 1.0 / d3
    p3 = k * q2 * id3
    pp3 = (q2s - k * ((bend - q2s) * it2) - p3 * p3) * id3
    return d1 + d2 + d3 - 3.0 * radius, p1 - p2 + p3, pp1 + pp2 + pp3


def offsets_m(hand: GraspHand) -> tuple[Float64, Float64]:
    """Of each knuckle from the little finger's: distal and lateral, shapes (4,) (eq. 5.5)."""
    y, z = hand.thesis_yz_m[:, 0], hand.thesis_yz_m[:, 1]
    return z - z[3], y - y[3]


def heights_m(hand: GraspHand, z_m: float, alpha_rad: float) -> Float64:
    """Height u of each knuckle over the object's axis, shape (4,) (eq. 5.5)."""
    distal, lateral = offsets_m(hand)
    return z_m + distal + lateral * math.tan(alpha_rad)


def projected_length_m(link_m: Float64, finger_normal: Float64, section_normal: Float64) -> Float64:
    """Length of a link as seen along the object's axis: eq. 5.6, repaired.

    The printed equation adds lengths to cosines; with e the direction common to both planes,
    l = sqrt((|a|^2 - (a.e)^2) (n_p.n_o)^2 + (a.e)^2) for a link that lies in the finger's plane.

    Args:
        link_m: Link as a vector in the finger's plane, shape (..., 3).
        finger_normal: Unit normal of the finger's plane, shape (..., 3).
        section_normal: Unit normal of the section (the object's axis), shape (..., 3).

    Returns:
        Projected length, shape (...), m.
    """
    square = (link_m**2).sum(axis=-1)
    cosine = (finger_normal * section_normal).sum(axis=-1)
    common = np.cross(section_normal, finger_normal)
    size = np.linalg.norm(common, axis=-1)
    parallel = size < 1e-12  # the two planes are one: nothing is foreshortened
    along = (link_m * common).sum(axis=-1) / np.where(parallel, 1.0, size)
    length: Float64 = np.sqrt(np.maximum(square - along**2, 0.0) * cosine**2 + along**2)
    return np.where(parallel, np.sqrt(square), length)
