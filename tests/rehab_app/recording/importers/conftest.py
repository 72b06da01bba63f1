"""A recording as motion capture would export it, made from a known hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from robot_iface.kinematics import couple_dip
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64


def closing_hand(frames: int) -> Float64:
    """All fingers close and open once, shape (frames, 21)."""
    joints = np.zeros((frames, 21))
    share = 0.5 * (1 - np.cos(np.linspace(0, 2 * np.pi, frames)))
    for row, name in enumerate(JOINTS):
        if name.endswith(("mcp_flexion", "pip", "_ip")):
            joints[:, row] = (0.3 if name.startswith("thumb") else 1.0) * share + 0.05
    return couple_dip(joints)


def markers(name: str, side: Side, frames: int) -> Float64:
    protocol = load_protocol(name)
    model = MarkerModel(average_subject(protocol, side), protocol)
    turn = Rotation.from_rotvec([0.3, 0.2, -0.5]).as_matrix()
    noise = 0.0005 * np.random.default_rng(1).standard_normal((frames, len(protocol.names), 3))
    return model.positions(closing_hand(frames)) @ turn.T + [0.1, 0.2, 0.4] + noise


@pytest.fixture(scope="session")
def tsv_text() -> str:
    """Two seconds of mocap13 at 100 Hz, a gap of 10 frames in thumb_tip, and a marker of something else."""
    protocol = load_protocol("mocap13")
    p_mm = 1e3 * markers("mocap13", "right", 200)
    p_mm[50:60, protocol.names.index("thumb_tip")] = 0.0
    names = (*protocol.names, "pillow_top")
    header = [
        "NO_OF_FRAMES\t200",
        "NO_OF_CAMERAS\t7",
        f"NO_OF_MARKERS\t{len(names)}",
        "FREQUENCY\t100",
        "DATA_INCLUDED\t3D",
        "TIME_STAMP\t2021-08-26, 15:19:24.317\t1483034.68525310",
        "MARKER_NAMES\t" + "\t".join(names),
        "Frame\tTime\t" + "\t".join(f"{name} {axis}" for name in names for axis in "XYZ"),
    ]
    rows = [
        f"{row + 1}\t{row / 100:.5f}\t" + "\t".join(f"{value:.3f}" for value in [*p_mm[row].ravel(), 1, 2, 3])
        for row in range(200)
    ]
    return "\n".join([*header, *rows]) + "\n"


@pytest.fixture(scope="session")
def landmarks_m() -> Float64:
    """Two seconds of a left hand in MediaPipe order at 30 Hz, shape (60, 21, 3)."""
    return markers("mediapipe21", "left", 60)


@pytest.fixture
def tsv(tmp_path: Path, tsv_text: str) -> Path:
    path = tmp_path / "take.tsv"
    path.write_text(tsv_text)
    return path
