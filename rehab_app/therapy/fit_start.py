"""Where a fit to positions begins: the nearest of some tabled postures, sample by sample."""

from __future__ import annotations

from itertools import product

import numpy as np
import numpy.typing as npt
from scipy.ndimage import median_filter

from robot_iface.kinematics import DIP_PER_PIP, HandGeometry, forward
from sessions.records import DIGITS, JOINTS, LANDMARKS, digit_of
from sessions.records.fields import Float64, Int64

_FLEXIONS = np.deg2rad(np.arange(0.0, 106.0, 15.0))
_ABDUCTIONS = np.deg2rad([-10.0, 0.0, 10.0])
_THUMB = (
    np.deg2rad([-15.0, 5.0, 25.0, 45.0]),
    np.deg2rad([-20.0, 0.0, 20.0, 40.0]),
    np.deg2rad([0.0, 25.0, 50.0]),
    np.deg2rad([0.0, 30.0, 60.0]),
)
_CALM = 5  # samples over which a lone swapped marker is outvoted


def starting_angles(geometry: HandGeometry, landmarks_m: Float64, seen: npt.NDArray[np.bool_]) -> Float64:
    """Rough angles at every sample.

    Args:
        geometry: The hand.
        landmarks_m: Landmarks in the palm frame, anything where unseen, shape (N, 25, 3).
        seen: Which are seen, shape (N, 25).

    Returns:
        Angles, shape (N, 21); a gap holds what lies between its ends, a digit never seen 0.
    """
    q = np.zeros((len(landmarks_m), len(JOINTS)))
    for digit in DIGITS:
        joints = np.array([row for row, name in enumerate(JOINTS) if digit_of(name) == digit])
        marks = np.array([row for row, name in enumerate(LANDMARKS) if digit_of(name) == digit])
        postures = _postures(digit, joints)
        placed_m = forward(geometry, postures).landmarks_m[:, marks]
        known = np.flatnonzero(seen[:, marks].any(axis=1))
        if known.size:
            nearest = _nearest(landmarks_m[known][:, marks], seen[known][:, marks], placed_m)
            rough = median_filter(postures[nearest][:, joints], (_CALM, 1), mode="nearest")
            rows = np.arange(len(q))
            for column, joint in enumerate(joints):
                q[:, joint] = np.interp(rows, known, rough[:, column])
    return q


def _nearest(x_m: Float64, seen: npt.NDArray[np.bool_], placed_m: Float64) -> Int64:
    """The posture (of P) whose landmarks lie nearest, by sample, shape (N,)."""
    weight = seen.astype(np.float64)
    flat = (weight[..., None] * x_m).reshape(len(x_m), -1)
    square = (placed_m**2).sum(axis=2)
    cost = weight @ square.T - 2.0 * flat @ placed_m.reshape(len(placed_m), -1).T
    return np.argmin(cost, axis=1)


def _postures(digit: str, joints: Int64) -> Float64:
    """Postures of a digit, all other joints straight, shape (P, 21)."""
    if digit == "thumb":
        rows = [(flex, abduct, mcp, 0.0, ip) for flex, abduct, mcp, ip in product(*_THUMB)]
    else:
        rows = [
            (mcp, abduct, pip, DIP_PER_PIP * pip)
            for mcp, abduct, pip in product(_FLEXIONS, _ABDUCTIONS, _FLEXIONS)
        ]
    postures = np.zeros((len(rows), len(JOINTS)))
    postures[:, joints] = np.array(rows)
    return postures
