"""The hand's bones as the header states them, and a finger's joints from its tip and angles."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sessions.records import DIGITS, JOINTS
from sessions.records.fields import Float64

_DEGENERATE = 1e-6


@dataclass(frozen=True, slots=True)
class HandBones:
    """Lengths and places that the header's hand geometry states, in the palm frame.

    Attributes:
        bases_m: Where each digit begins: the finger's MCP, shape (5, 3).
        bones_m: Lengths of its three bones, shape (5, 3).
    """

    bases_m: Float64
    bones_m: Float64


def bones_of(subject_hand: str) -> HandBones | None:
    """The bones in a header's ``subject_hand``, None where it holds none.

    Args:
        subject_hand: JSON of a hand, or anything else.
    """
    try:
        table: Any = json.loads(subject_hand)
        bases = np.asarray(table["bases_m"], dtype=np.float64)
        bones = np.asarray(table["bones_m"], dtype=np.float64)
        mirrored = table["side"] == "left"
    except (ValueError, KeyError, TypeError):
        return None
    if bases.shape != (5, 3) or bones.shape != (5, 3) or not bool((bones > 0.0).all()):
        return None
    if not bool(np.isfinite(bases).all() and np.isfinite(bones).all()):
        return None
    return HandBones(bases * np.array([1.0, -1.0 if mirrored else 1.0, 1.0]), bones)


def finger_points_m(bones: HandBones, finger: str, tips_m: Float64, joints_rad: Float64) -> Float64:
    """MCP, PIP, DIP and tip of a finger.

    A finger bends within one plane, which the palm's normal and the line from knuckle to tip span; the angles
    of PIP and DIP say where in that plane the joints are.

    Args:
        bones: The hand's bones.
        finger: Index to little.
        tips_m: Its tip in the palm frame, shape (N, 3).
        joints_rad: All joints of the hand, shape (N, 21).

    Returns:
        Shape (N, 4, 3), palm frame; NaN where an angle is missing or where the finger points straight
        out of the palm.
    """
    row = DIGITS.index(finger)
    base, (first, second, third) = bones.bases_m[row], bones.bones_m[row]
    pip, dip = (joints_rad[:, JOINTS.index(f"{finger}_{joint}")] for joint in ("pip", "dip"))
    along = np.column_stack(
        [np.full(pip.shape, first), second * np.cos(pip), third * np.cos(pip + dip)]
    ).cumsum(axis=1)
    across = np.column_stack([np.zeros(pip.shape), second * np.sin(pip), third * np.sin(pip + dip)]).cumsum(
        axis=1
    )
    reach = tips_m - base
    sideways = np.hypot(reach[:, 1], reach[:, 2])
    forward = np.sign(np.where(reach[:, 2] == 0.0, 1.0, reach[:, 2]))
    turned = np.arctan2(reach[:, 0], forward * sideways) - np.arctan2(across[:, 2], along[:, 2])
    with np.errstate(invalid="ignore", divide="ignore"):
        direction = reach * np.array([0.0, 1.0, 1.0]) * (forward / sideways)[:, None]
    direction[~(sideways > _DEGENERATE)] = math.nan
    outward = np.cos(turned)[:, None] * along - np.sin(turned)[:, None] * across
    palmar = np.sin(turned)[:, None] * along + np.cos(turned)[:, None] * across
    bent = outward[..., None] * direction[:, None, :] + palmar[..., None] * np.array([1.0, 0.0, 0.0])
    return np.concatenate([np.broadcast_to(base, (len(tips_m), 1, 3)), base + bent], axis=1)
