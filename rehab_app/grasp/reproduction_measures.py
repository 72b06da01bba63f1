"""Chapter 3 of the thesis: hands measured by glove and by cameras."""

from __future__ import annotations

import numpy as np

from rehab_app.grasp.curvature import joint_curvature_per_m
from rehab_app.grasp.reproduction import Line, Part, compared
from rehab_app.grasp.shape_tables import APERTURE_DEG, GLOVE_APERTURE_DEG, INDEX_RADIUS_MM, table_spread
from robot_iface.kinematics import average_hand, forward
from sessions.records import JOINTS, LANDMARKS
from sessions.records.fields import Float64

_POSES = 200
_STATED_TRANSVERSE_DEG = 56.0  # "56 degrees on average for the human hand", section 5.2.3


def chapter_3() -> tuple[Part, ...]:
    """Tables 3.1 to 3.6, Figures 3.1 to 3.15."""
    return *_by_glove(), *_by_cameras()


def _by_glove() -> tuple[Part, ...]:
    return (
        Part(
            "Table 3.1, Figures 3.1 to 3.3: the glove",
            "22 sensors, numbered as printed, are columns of the glove import (`docs/hand-shape.md`); "
            "angles count from the "
            "first frame as in 3.1.2. Sensors 19 to 21 (palm arch, wrist) move no joint of this hand. "
            "The recordings are not "
            "published: the photographs and set-up have no counterpart here.",
        ),
        _chains(),
        Part(
            "Figure 3.5: glove angles over trials",
            "Not reproducible: the ten people's angles are not published, and the figure cannot be read "
            "to a degree.",
        ),
        Part(
            "Table 3.4: aperture by glove",
            "Means over people of the printed rows. The thesis prints no overall mean; chapter 5 uses "
            "Table 3.6's instead.",
            (_over_people("transverse, 10 people", GLOVE_APERTURE_DEG, "deg"),),
        ),
    )


def _by_cameras() -> tuple[Part, ...]:
    return (
        Part(
            "Figures 3.6 to 3.14: marker protocols and set-up",
            "The protocol of Figure 3.9 is `thesis25`: four markers a digit, wrist, CMC4 and three of "
            "the palm. The other "
            "groups' protocols, cameras, objects and the reconstruction software have no counterpart. "
            "C3D files of such a "
            "system are imported.",
        ),
        Part(
            "Table 3.5, Figure 3.15: radius of curvature of the index finger",
            "Natural cubic spline through the four joints. "
            + _ends()
            + " Below: means over the seven people of the printed rows.",
            tuple(
                _over_people(f"{joint.upper()}, {grip}, 7 people", rows, "mm")
                for (joint, grip), rows in INDEX_RADIUS_MM.items()
            ),
        ),
        Part(
            "Table 3.6: aperture with cameras",
            "The transverse mean is what section 5.2.3 states as 56 degrees and what the thumb's rule "
            "builds on.",
            (
                _over_people("diagonal, 7 people", APERTURE_DEG["diagonal"], "deg"),
                compared(
                    "transverse, 7 people, against the mean stated in 5.2.3",
                    _STATED_TRANSVERSE_DEG,
                    float(table_spread(APERTURE_DEG["transverse"]).mean),
                    "deg",
                    2,
                ),
            ),
        ),
    )


def _over_people(what: str, rows: tuple[float, ...], unit: str) -> Line:
    found = table_spread(rows)
    text = f"{float(found.mean):.2f} +- {float(found.sd):.2f} {unit}"
    return Line(what, "rows only", text, "arithmetic of the printed rows")


def _ends() -> str:
    """What curvature a natural spline has at its ends, found on random fingers."""
    points = np.cumsum(np.random.default_rng(35).uniform(0.01, 0.04, (_POSES, 4, 3)), axis=1)
    curvature = joint_curvature_per_m(points)
    largest = float(np.abs(curvature[:, [0, 3]]).max())
    return (
        f"At MCP and TIP it has no curvature (largest here over {_POSES} random fingers: {largest:.0f} "
        f"1/m), so the radii of 1e16 mm "
        "and more that the thesis prints there are round-off and are left out."
    )


def _chains() -> Part:
    """Tables 3.2 and 3.3 against the kinematics of the product."""
    return Part(
        "Tables 3.2 and 3.3, Figure 3.4: chains of index finger and thumb",
        "The index chain in the classical form (Rz Tz Tx Rx): abduction and flexion cross in the "
        "knuckle, hinges follow. The product's "
        "own chain of the same bones puts every joint in the same place. The thumb's table puts a "
        "phalanx between its first "
        "two, perpendicular axes; the text says that they cross in one joint (TM) and that MCP and IP "
        "are hinges, as in the product. "
        "The table is read as a misprint.",
        (
            Line(
                f"index, {_POSES} random postures, largest distance of a joint",
                "chain of Table 3.2",
                "chain of the product",
                "below 1e-12 m" if _index_difference_m() < 1e-12 else f"{_index_difference_m():.1e} m",
            ),
        ),
    )


def _index_difference_m() -> float:
    """Largest distance of PIP, DIP and TIP between the chain of Table 3.2 and ours."""
    rng = np.random.default_rng(32)
    angles = rng.uniform([-0.3, -0.3, 0.0, 0.0], [0.3, 1.5, 1.8, 1.2], (_POSES, 4))
    hand = average_hand()
    joints = np.zeros((_POSES, len(JOINTS)))
    names = ("index_mcp_abduction", "index_mcp_flexion", "index_pip", "index_dip")
    joints[:, [JOINTS.index(name) for name in names]] = angles
    points = forward(hand, joints).landmarks_m
    first = LANDMARKS.index("index_mcp")
    ours = points[:, first + 1 : first + 4] - points[:, first : first + 1]
    # the table's knuckle frame is (distal, ulnar, palmar); the product's palm frame (palmar, radial, distal)
    table = _table_3_2(angles, hand.bones_m[1])[..., [2, 1, 0]] * np.array([1.0, -1.0, 1.0])
    return float(np.linalg.norm(ours - table, axis=-1).max())


def _table_3_2(angles_rad: Float64, bones_m: Float64) -> Float64:
    """PIP, DIP and TIP in the frame of the knuckle by rows 2 to 5 of Table 3.2, shape (N, 3, 3)."""
    abduction, flexion, pip, dip = (-angles_rad[:, 0], *angles_rad[:, 1:].T)
    still = np.zeros_like(flexion)
    frame = _classical(abduction, 0.0, np.pi / 2)
    places = []
    for angle, length in zip((flexion, pip, dip), bones_m, strict=True):
        frame = frame @ _classical(angle + still, float(length), 0.0)
        places.append(frame[:, :3, 3])
    return np.stack(places, axis=1)


def _classical(theta_rad: Float64, a_m: float, alpha_rad: float) -> Float64:
    """Rz(theta) Tx(a) Rx(alpha), shape (N, 4, 4)."""
    ct, st = np.cos(theta_rad), np.sin(theta_rad)
    ca, sa = float(np.cos(alpha_rad)), float(np.sin(alpha_rad))
    frame = np.zeros((len(theta_rad), 4, 4))
    frame[:, 0, 0], frame[:, 0, 1], frame[:, 0, 2], frame[:, 0, 3] = ct, -st * ca, st * sa, a_m * ct
    frame[:, 1, 0], frame[:, 1, 1], frame[:, 1, 2], frame[:, 1, 3] = st, ct * ca, -ct * sa, a_m * st
    frame[:, 2, 1], frame[:, 2, 2], frame[:, 3, 3] = sa, ca, 1.0
    return frame
