"""A clinic with one take of a synthetic hand whose truth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.hand.protocol import load_protocol
from robot_iface.kinematics import average_hand, couple_dip, forward
from robot_iface.types import FINGERS, JOINTS, LANDMARKS

CLOSED_RAD = np.deg2rad(35.0)


def landmarks_file(path: Path, seconds: float = 3.0, side: str = "right") -> Path:
    """A MediaPipe landmark array of a hand that closes and opens once; every finger joint by 35 degrees."""
    t_s = np.arange(round(seconds * 30.0)) / 30.0
    closed = CLOSED_RAD * 0.5 * (1.0 - np.cos(2.0 * np.pi * t_s / seconds))
    joints = np.zeros((t_s.size, 21))
    for finger in FINGERS:
        for joint in ("mcp_flexion", "pip"):
            joints[:, JOINTS.index(f"{finger}_{joint}")] = closed
    points = forward(average_hand(0.185, side), couple_dip(joints)).landmarks_m
    names = [name for name in load_protocol("mediapipe21").names]
    order = [LANDMARKS.index(name) for name in names]
    noise = np.random.default_rng(5).normal(0.0, 0.0005, (t_s.size, 21, 3))
    np.savez(path, landmarks_m=points[:, order] + noise + [0.0, 0.0, 0.7], fps=30)
    return path


@pytest.fixture(scope="session")
def recording(tmp_path_factory):
    return landmarks_file(tmp_path_factory.mktemp("recording") / "hand.npz")


@pytest.fixture(scope="session")
def take_file(tmp_path_factory, recording):
    """A sealed take, imported once."""
    folder = tmp_path_factory.mktemp("take")
    with open_clinic(folder / "clinic") as clinic:
        clinic.takes.import_file(recording, side="right", actor=CONSOLE, out=folder / "hand.mcap")
    return folder / "hand.mcap"


@pytest.fixture(scope="module")
def stocked(tmp_path_factory, take_file):
    """A clinic with one take that nobody approved."""
    with open_clinic(tmp_path_factory.mktemp("stocked")) as clinic:
        clinic.takes.get(take_file)
        yield clinic
