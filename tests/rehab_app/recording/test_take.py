from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.hand.subject import geometry_to_json
from rehab_app.recording.take import TakeRecorder, hand_transforms, read_motion, write_take
from robot_iface.kinematics import average_hand, forward
from sessions.errors import Refused
from sessions.records import HandPose, MarkerFrame, Status
from sessions.records.header import SessionHeader
from sessions.records.topics import HAND_JOINTS, MARKERS, TRANSFORMS
from sessions.store import SessionReader

GEOMETRY = average_hand(0.18, "left")


def header(**changes: Any) -> SessionHeader:
    fields: dict[str, Any] = {
        "session_id": "0" * 32,
        "kind": "take",
        "subject_id": "p1",
        "side": "left",
        "exercise": "open_close",
        "source": "test",
        "software_version": "0",
        "utc_start_ns": 1_700_000_000_000_000_000,
        "monotonic_start_ns": 0,
        "marker_names": ("a", "b"),
        "subject_hand": geometry_to_json(GEOMETRY),
    }
    return SessionHeader(**(fields | changes))


def frames(count: int, period_ns: int = 10_000_000) -> Iterator[tuple[MarkerFrame, HandPose]]:
    rng = np.random.default_rng(1)
    for row in range(count):
        joints = rng.uniform(0, 1, 21)
        status = np.full(21, Status.MEASURED, dtype=np.uint8)
        tips = forward(GEOMETRY, joints).landmarks_m[[3, 7, 11, 15, 19]].copy()
        if row % 3 == 0:  # the index finger is lost
            joints[5:9], status[5:9], tips[1] = np.nan, Status.LOST, np.nan
        palm = np.array([0.0, 0.0, 0.7]) if row % 5 else np.full(3, np.nan)
        yield (
            MarkerFrame(
                t_ns=row * period_ns,
                p_camera_m=rng.normal(size=(2, 3)),
                covariance_m2=np.tile(np.eye(3), (2, 1, 1)),
                status=np.array([2, 2], dtype=np.uint8),
                pixel_px=np.full((2, 2), np.nan),
                similarity=np.ones(2),
            ),
            HandPose(
                t_ns=row * period_ns,
                p_camera_palm_m=palm,
                q_camera_palm_wxyz=np.array([1.0, 0.0, 0.0, 0.0]),
                joints_rad=joints,
                joint_covariance_rad2=0.01 * np.eye(21),
                joint_status=status,
                fingertips_palm_m=tips,
                fingertip_covariance_m2=np.tile(1e-6 * np.eye(3), (5, 1, 1)),
                residual_m=0.001,
            ),
        )


def test_a_take_comes_back_with_its_gaps(tmp_path: Path) -> None:
    sealed = write_take(tmp_path / "t.mcap", header(), frames(150))
    with SessionReader(sealed.path) as reader:
        motion = read_motion(reader)
        counts = reader.counts
        children = {name for record in reader.records(TRANSFORMS) for name in record.children}
    written = [pose for _, pose in frames(150)]
    np.testing.assert_array_equal(motion.joints_rad, [pose.joints_rad for pose in written])
    np.testing.assert_array_equal(motion.joint_status, [pose.joint_status for pose in written])
    np.testing.assert_allclose(motion.fingertips_palm_m, [pose.fingertips_palm_m for pose in written])
    np.testing.assert_allclose(motion.t_s, 0.01 * np.arange(150))
    np.testing.assert_array_equal(motion.geometry.bones_m, GEOMETRY.bones_m)
    assert motion.side == "left"
    assert counts[MARKERS.name] == 150
    assert counts[HAND_JOINTS.name] <= 30 * 1.49 + 1
    assert {"reference/palm", "reference/index_tip", "reference/wrist"} <= children


def test_a_lost_finger_has_no_frames() -> None:
    _, pose = next(frames(1))
    placed = hand_transforms(GEOMETRY, pose)
    assert "reference/index_tip" not in placed.children
    assert "reference/index_mcp" in placed.children
    assert "reference/ring_tip" in placed.children
    assert np.isfinite(placed.p_parent_child_m[1:]).all()


def test_a_short_take_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="1 s or longer"):
        write_take(tmp_path / "t.mcap", header(), frames(100))
    assert not list(tmp_path.iterdir())


def test_a_failure_on_the_way_leaves_nothing(tmp_path: Path) -> None:
    def failing() -> Iterator[tuple[MarkerFrame, HandPose]]:
        yield from frames(120)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_take(tmp_path / "t.mcap", header(), failing())
    assert not list(tmp_path.iterdir())


def test_leaving_a_recorder_keeps_what_can_be_recovered(tmp_path: Path) -> None:
    with TakeRecorder(tmp_path / "t.mcap", header()) as recorder:
        for markers, pose in frames(120):
            recorder.add(markers, pose)
    assert [path.name for path in tmp_path.iterdir()] == ["t.partial.mcap"]


def test_time_must_rise(tmp_path: Path) -> None:
    with TakeRecorder(tmp_path / "t.mcap", header()) as recorder:
        markers, pose = next(frames(1))
        recorder.add(markers, pose)
        with pytest.raises(Refused, match="rising"):
            recorder.add(markers, pose)
        recorder.discard()


def test_a_header_without_a_hand_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="hand geometry"):
        TakeRecorder(tmp_path / "t.mcap", header(subject_hand=""))
    assert not list(tmp_path.iterdir())


def test_a_session_that_is_no_take_has_no_motion(tmp_path: Path) -> None:
    sealed = write_take(tmp_path / "t.mcap", header(kind="therapy"), frames(120))
    with SessionReader(sealed.path) as reader, pytest.raises(Refused, match="a take"):
        read_motion(reader)
