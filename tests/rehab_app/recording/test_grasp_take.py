"""A computed grasp as a take: sealed, whole, nothing in it called measured, and it ends where it should."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehab_app.errors import Refused
from rehab_app.grasp.hand import human_hand, robot_hand
from rehab_app.grasp.objects import Cylinder
from rehab_app.grasp.posture import find_posture
from rehab_app.grasp.spiral import spiral_path
from rehab_app.recording.grasp_take import write_grasp_take
from rehab_app.recording.take import read_motion
from robot_iface.kinematics import average_hand, forward
from sessions.records import JOINTS, Status
from sessions.store import SessionReader, verify


def test_it_opens_closes_holds_and_opens_again(tmp_path: Path) -> None:
    hand = human_hand(average_hand(0.2, "left"))
    way = spiral_path(find_posture(hand, Cylinder(0.03)))
    sealed = write_grasp_take(
        tmp_path / "grasp.mcap",
        way,
        hand,
        exercise="cylinder",
        software_version="0",
        closing_s=2.0,
        hold_s=1.0,
    )
    verify(sealed.path)
    with SessionReader(sealed.path) as reader:
        assert (reader.header.source, reader.header.exercise) == ("grasp", "cylinder")
        motion = read_motion(reader)
    assert motion.side == "left"
    assert motion.geometry.length_m == pytest.approx(0.2)
    assert motion.t_s[-1] == pytest.approx(5.0)
    held = (motion.t_s >= 2.0) & (motion.t_s <= 3.0)
    np.testing.assert_allclose(
        motion.joints_rad[held], np.tile(way.joints_rad[-1], (held.sum(), 1)), atol=1e-9
    )
    np.testing.assert_allclose(motion.joints_rad[[0, -1]], way.joints_rad[[0, 0]], atol=1e-9)
    assert (motion.joint_status == Status.ESTIMATED).all()
    tips = forward(motion.geometry, motion.joints_rad).landmarks_m[:, [3, 7, 11, 15, 19]]
    np.testing.assert_allclose(motion.fingertips_palm_m, tips, atol=1e-6)
    speed = np.diff(motion.joints_rad[:, JOINTS.index("index_mcp_flexion")]) / np.diff(motion.t_s)
    assert abs(speed[0]) < 0.01
    assert abs(speed[-1]) < 0.01


def test_the_robots_own_grasp_is_no_persons_take(tmp_path: Path) -> None:
    hand = robot_hand()
    way = spiral_path(find_posture(hand, Cylinder(0.02)))
    with pytest.raises(Refused, match="--hand human"):
        write_grasp_take(tmp_path / "x.mcap", way, hand, exercise="x", software_version="0")
    assert list(tmp_path.iterdir()) == []


def test_times_out_of_bounds_leave_no_file(tmp_path: Path) -> None:
    hand = human_hand(average_hand())
    way = spiral_path(find_posture(hand, Cylinder(0.03)))
    with pytest.raises(Refused, match="closing time"):
        write_grasp_take(
            tmp_path / "x.mcap", way, hand, exercise="x", software_version="0", closing_s=float("nan")
        )
    assert list(tmp_path.iterdir()) == []
