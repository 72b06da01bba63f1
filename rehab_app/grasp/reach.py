"""From a grip to a trial of reaching for it and holding it (thesis, section 5.2), in simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.grasp.hand import robot_hand
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import Posture, find_posture
from robot_iface.build import FreeCylinder, Grasp, reach_and_grasp
from sessions.records import FINGERS
from sessions.records.fields import Float64

TOP_M = 0.022
"""How far the cylinder's end stands radial of the wrist: just under the thumb, which cannot clear more."""
_THUMB = ("cmc_abduction", "cmc_flexion", "mcp_flexion")


@dataclass(frozen=True, slots=True)
class Reached:
    """A trial in the words of a report.

    Attributes:
        grasp: The trial.
        moved_m: How far the object went without the table, by gravity alone and under the worst push, (2,).
        turned_rad: How far it turned at most.
        arm_error_m: Largest distance of the arm's end from its reference, and that at the end, (2,).
    """

    grasp: Grasp
    moved_m: Float64
    turned_rad: float
    arm_error_m: Float64


def reach_for(radius_m: float) -> Reached:
    """The DLR-HIT-Hand II brought to a cylinder, closed around it, the table taken away, the object pushed.

    Args:
        radius_m: Radius of the cylinder.

    Raises:
        Refused: The hand cannot hold a cylinder of that radius.
    """
    hand = robot_hand()
    posture = find_posture(hand, Cylinder(radius_m), "transverse", "contact", 0.0)
    distal_m = float(hand.knuckles_m[3, 2]) - posture.z_m
    grasp = reach_and_grasp(ordered_rad(posture), FreeCylinder(radius_m, distal_m, TOP_M))
    off_m = np.linalg.norm(grasp.record.end_m - grasp.record.end_reference_m, axis=1)
    return Reached(
        grasp=grasp,
        moved_m=np.array([grasp.held[0].moved_m, max(one.moved_m for one in grasp.held[1:])]),
        turned_rad=max(one.turned_rad for one in grasp.held),
        arm_error_m=np.array([off_m.max(), off_m[-1]]),
    )


def ordered_rad(posture: Posture) -> Float64:
    """The robot's posture as the trial takes it: abduction, MCP and PIP of five digits, shape (5, 3)."""
    angles = posture.angles_rad
    thumb = [angles[f"thumb_{joint}"] for joint in _THUMB]
    long = [[0.0, angles[f"{name}_mcp_flexion"], angles[f"{name}_pip"]] for name in FINGERS]
    return np.array([thumb, *long])
