"""Tables of chapter 5 of the thesis, as printed, and the one that is read otherwise."""

from __future__ import annotations

HAND_MM: dict[str, float] = {
    "a_01": 117.0,
    "a_02": 118.3,
    "a_03": 117.0,
    "a_04": 105.0,
    "a_1": 55.0,
    "a_2": 25.0,
    "a_3": 25.0,
    "t_0": 62.0,
    "t_1": 35.0,
    "t_2": 26.0,
    "t_3": 24.0,
}
"""Table 5.2: wrist to knuckles (index to little), links, thicknesses, mm."""
ARM_LINKS_M = (0.551, 0.407)
"""Table 5.1: link lengths of the MIT-Manus, m."""
RADIUS_MM: dict[str, dict[str, dict[str, float]]] = {
    "human": {
        "index": {"pip": 28, "dip": 33},
        "middle": {"pip": 37, "dip": 32},
        "ring": {"pip": 37, "dip": 38},
        "little": {"pip": 43, "dip": 32},
        "thumb": {"mcp": 51, "ip": 28},
    },
    "algorithm": {
        "index": {"pip": 24, "dip": 29},
        "middle": {"pip": 24, "dip": 28},
        "ring": {"pip": 23, "dip": 30},
        "little": {"pip": 33, "dip": 14},
        "thumb": {"mcp": 18, "ip": 25},
    },
    "robot": {
        "index": {"pip": 25, "dip": 19},
        "middle": {"pip": 22, "dip": 16},
        "ring": {"pip": 24, "dip": 18},
        "little": {"pip": 27, "dip": 20},
        "thumb": {"mcp": 43, "ip": 32},
    },
}
"""Table 5.4 without its end joints, mm. The robot's ring PIP is printed .24 m and read as .024 m."""
OBJECT_RADIUS_M = 0.0225
"""Radius for which Table 5.4 says that it holds; its human column is that of the 30 mm of Table 3.5."""
HUMAN_OBJECT_RADIUS_M = 0.030
CMC_M = (-0.0975, -0.179, 0.15)
OBJECT_M = (-0.051, -0.257)
"""Section 5.2.3, r = 20 mm: the wrist and the object in the MIT-Manus frame, m."""
THUMB_DEG: dict[str, float] = {"opposition": 35.51, "inclination": 44.13, "aperture": 37.0}
"""Where the robot's thumb is fixed, and its aperture ("about 37 degrees")."""
