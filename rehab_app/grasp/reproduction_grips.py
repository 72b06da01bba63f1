"""Chapter 5 of the thesis: the posture of a power grip, its path, and the robot's hand."""

from __future__ import annotations

import math

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.hand import coupled, human_hand, robot_hand
from rehab_app.grasp.newton import TangentObjective
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import Posture, find_posture
from rehab_app.grasp.reproduction import Line, Part, compared
from rehab_app.grasp.reproduction_reach import reach_part
from rehab_app.grasp.spiral import spiral_path
from rehab_app.grasp.tangent import projected_length_m
from rehab_app.grasp.thesis_tables import (
    HAND_MM,
    HUMAN_OBJECT_RADIUS_M,
    OBJECT_RADIUS_M,
    RADIUS_MM,
    THUMB_DEG,
)
from robot_iface.kinematics import average_hand
from robot_iface.kinematics.dlr_hit import (
    THUMB_INCLINATION_RAD,
    THUMB_OPPOSITION_RAD,
    aperture_rad,
    dlr_hit_hand,
    finger_points,
)
from sessions.records import FINGERS, JOINTS

_PLANES = 2000
_STARTS = 300
_STRAIGHT_MM = 105.0


def chapter_5() -> tuple[Part, ...]:
    """Tables 5.1 to 5.4, Figures 5.1 to 5.12, equations 5.1 to 5.8."""
    return (
        Part(
            "Figures 5.1 to 5.4, equations 5.1 to 5.6: the optimal posture",
            "As printed, equations 5.2 to 5.4 give distances of joints from the object's axis, not from "
            "its surface, and add radii "
            "twice; equation 5.6 adds lengths to cosines. Repaired (`docs/grasp.md`), with half "
            "thicknesses:",
            (_optimum(), _projection()),
        ),
        Part(
            "Figures 5.5 and 5.6, equations 5.7 and 5.8: the path",
            "Fingertips on logarithmic spirals about their knuckles, joints by inverse kinematics with "
            "the coupling. The straight finger of the "
            "figure is singular: paths begin with bent middle joints.",
            (_path(),),
        ),
        _geometry(),
        Part(
            "Figures 5.7, 5.9 and 5.10: set-up, diagonal and transverse grip",
            "The figures print no coordinates. `rehab-app grasp --plot` draws ours. The robot's thumb "
            "allows transverse grips only, as the "
            "thesis says; a person's diagonal grip is computed for people.",
            (_grip("transverse"), _grip("diagonal")),
        ),
        *(_radii(column) for column in ("robot", "algorithm", "human")),
        reach_part(),
        Part(
            "Section 5.2.3: the wrist beside the object",
            "Of the printed places (object at (-.051, -.257) m, wrist at (-.0975, -.179) m) the wrist lies "
            "78 mm from the object's axis along the fingers. None of three readings gives that: the optimum "
            f"of 20 mm puts it {', '.join(f'{value:.0f}' for value in _wrist_mm())} mm away (optimum free, "
            "alpha = 0, and that measured to the ring finger's knuckle instead of the little finger's). "
            "Published as not reproducible.",
        ),
    )


def _optimum() -> Line:
    objective = TangentObjective(robot_hand())
    rng = np.random.default_rng(56)
    found = [
        objective.minimum(
            OBJECT_RADIUS_M, start=(float(rng.uniform(-0.1, 0.1)), float(rng.uniform(-1.0, 1.0)))
        )
        for _ in range(_STARTS)
    ]
    first = found[0]
    same = sum(
        abs(one.z_m - first.z_m) < 1e-6 and abs(one.alpha_rad - first.alpha_rad) < 1e-5 for one in found
    )
    ours = (
        f"z {1e3 * first.z_m:.3f} mm, alpha {math.degrees(first.alpha_rad):.3f} deg, f "
        f"{first.objective_m:.6f} m; "
        f"the same from {same} of {_STARTS} starts"
    )
    return Line("optimum, robot, r = 22.5 mm", "not printed", ours, "-")


def _projection() -> Line:
    rng = np.random.default_rng(57)
    planes = rng.normal(size=(2, _PLANES, 3))
    finger, section = planes / np.linalg.norm(planes, axis=-1, keepdims=True)
    link = np.cross(finger, rng.normal(size=(_PLANES, 3)))
    true = np.linalg.norm(link - (link * section).sum(axis=1, keepdims=True) * section, axis=1)
    worst = float(np.abs(projected_length_m(link, finger, section) - true).max())
    ours = "below 1e-12" if worst < 1e-12 else f"{worst:.1e}"
    return Line(f"eq. 5.6, {_PLANES} random planes", "-", ours, "largest distance from the true projection")


def _path() -> Line:
    posture = find_posture(human_hand(average_hand()), Cylinder(HUMAN_OBJECT_RADIUS_M), "transverse")
    way = spiral_path(posture)
    reached = max(
        abs(float(way.joints_rad[-1, index]) - posture.angles_rad[name])
        for index, name in enumerate(JOINTS)
        if name in posture.angles_rad
    )
    ends = "end met to 1e-9 rad" if reached < 1e-9 else f"end missed by {reached:.1e} rad"
    start = f"middle joints from {math.degrees(way.start_pip_rad):.0f} deg"
    turns = "every joint one way" if not way.warnings else "; ".join(way.warnings)
    return Line("person of 189 mm, 60 mm cylinder", "spiral, no numbers", f"{ends}, {start}, {turns}", "-")


def _geometry() -> Part:
    hand, robot = dlr_hit_hand(), robot_hand()
    straight = 1e3 * float(np.linalg.norm(finger_points(np.zeros(3))[-1]))
    sizes = {
        **{f"a_0{index + 1}": 1e3 * float(hand.distance_m[index]) for index in range(4)},
        **{f"a_{index + 1}": 1e3 * float(robot.links_m[0, index]) for index in range(3)},
        "t_0": 2e3 * robot.palm_half_m,
        **{f"t_{index + 1}": 2e3 * float(robot.half_m[0, index]) for index in range(3)},
    }
    worst = max(abs(sizes[name] - value) for name, value in HAND_MM.items())
    agree = f"all within {worst:.3f} mm" if worst > 1e-9 else "all as printed"
    return Part(
        "Tables 5.1 to 5.3, Figure 5.8: arm and hand",
        "Table 5.3 holds only in the modified (Craig) form. The twist angles of Table 5.1 would fold the "
        "planar arm out of its "
        "plane and are read as a misprint; its links are those of the simulated arm. Lateral places of "
        "the knuckles are "
        "not in the thesis and come from the hand's public description.",
        (
            Line("Table 5.2, 11 sizes", "as printed", "geometry of the product", agree),
            compared("Table 5.3, straight fingertip from its base", _STRAIGHT_MM, straight, "mm", 3),
            compared(
                "thumb opposition", THUMB_DEG["opposition"], math.degrees(THUMB_OPPOSITION_RAD), "deg", 2
            ),
            compared(
                "thumb inclination", THUMB_DEG["inclination"], math.degrees(THUMB_INCLINATION_RAD), "deg", 2
            ),
            compared('aperture ("about")', THUMB_DEG["aperture"], math.degrees(aperture_rad(hand)), "deg", 2),
        ),
    )


def _grip(grip: str) -> Line:
    posture = find_posture(human_hand(average_hand()), Cylinder(HUMAN_OBJECT_RADIUS_M), grip)
    ours = (
        f"z {1e3 * posture.z_m:.1f} mm, alpha {math.degrees(posture.alpha_rad):.1f} deg, "
        f"{len(posture.contacts)} contacts, deepest cut {1e3 * posture.penetration_m:.3f} mm"
    )
    return Line(f"{grip}, person of 189 mm, r = 30 mm", "picture", ours, "-")


def _radii(column: str) -> Part:
    """One column of Table 5.4."""
    posture, words = _of_column(column)
    lines: list[Line] = []
    shares: list[float] = []
    for digit, joints in RADIUS_MM[column].items():
        for joint, printed in joints.items():
            ours = 1e3 * posture.radius_m[digit][joint]
            lines.append(compared(f"{digit} {joint.upper()}", printed, ours, "mm", 1))
            if digit in _compared(column):
                shares.append(abs(ours / printed - 1.0))
    mean, worst = 100.0 * float(np.mean(shares)), 100.0 * max(shares)
    digits = _compared(column)
    summary = f"{digits[0].capitalize()} to {digits[-1]}: mean {mean:.1f} %, worst {worst:.1f} %."
    return Part(f"Table 5.4, column {column}: radii of curvature", f"{words} {summary}", tuple(lines))


def _compared(column: str) -> tuple[str, ...]:
    """Digits whose radii can be reproduced; the others are reported all the same."""
    return FINGERS[:3] if column == "algorithm" else FINGERS


def _of_column(column: str) -> tuple[Posture, str]:
    ring = "The ring finger's PIP is printed .24 m and read as .024 m."
    if column == "robot":
        return find_posture(robot_hand(), Cylinder(OBJECT_RADIUS_M), "transverse", "thesis", 0.0), (
            f"Tangent posture, r = 22.5 mm, alpha = 0, middle and distal joints coupled 1 : 1. {ring} "
            "The thumb's radii are not reproducible: with the robot's equal links the tangent thumb is "
            "curved as the fingers are."
        )
    if column == "algorithm":
        hand = coupled(robot_hand(), 2.0 / 3.0)
        return find_posture(hand, Cylinder(OBJECT_RADIUS_M), "transverse", "thesis", 0.0), (
            "The same with the coupling 2 / 3. Little finger and thumb are not reproducible: turned back "
            "into angles, the printed "
            "radii need couplings of 1.35 and .73."
        )
    return find_posture(human_hand(average_hand()), Cylinder(HUMAN_OBJECT_RADIUS_M), "transverse"), (
        "The caption says r = 22.5 mm; the values are the means over people of Table 3.5, whose object "
        "was 60 mm thick. Ours is the "
        "contact posture of an average hand of 189 mm around that object; its thumb is nearly straight, "
        "where a radius means little."
    )


def _wrist_mm() -> tuple[float, ...]:
    """Axial distance of the wrist from the axis of r = 20 mm, by three readings."""
    hand = robot_hand()
    objective = TangentObjective(hand)
    distal = hand.thesis_yz_m[:, 1]
    free = objective.minimum(0.020)
    level = objective.minimum(0.020, 0.0)
    readings = (
        float(distal[3]) - free.z_m,
        float(distal[3]) - level.z_m,
        float(distal[2]) - level.z_m,
    )
    if min(readings) <= 0.0:
        raise Refused("wrist", "beyond the object", "this side of it", "check the optimum")
    return tuple(1e3 * value for value in readings)
