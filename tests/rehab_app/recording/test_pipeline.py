"""From the virtual camera to a sealed take: what moved is what the file says."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from rehab_app.cameras import virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.pipeline import LivePose
from rehab_app.recording.recorder import RecordedTake, TakeOrder, record_take
from rehab_app.recording.take import read_motion
from sessions.errors import Refused
from sessions.metrics.motion_range import joint_range
from sessions.records import JOINTS, Side, Status
from sessions.records.topics import MARKERS
from sessions.store import SessionReader, partials, verify
from sessions.timebase import Timebase

PROTOCOL = load_protocol("thesis25")
INDEX_PIP = JOINTS.index("index_pip")


def order(folder: Path, side: Side = "right", seconds: float = 3.4, exercise: str = "index_pip") -> TakeOrder:
    return TakeOrder(folder / "take.mcap", side, exercise, seconds, "0.0.0", "P-1")


def record(
    folder: Path, side: Side = "right", seed: int = 0, length_m: float = 0.185, exercise: str = "index_pip"
) -> RecordedTake:
    camera = virtual_camera(exercise, side, 3.4, PROTOCOL, seed=seed, length_m=length_m, period_s=2.0)
    return record_take(camera, PROTOCOL, order(folder, side, exercise=exercise), timebase=Timebase(10**18, 0))


@pytest.mark.parametrize(
    ("side", "length_m", "seed"),
    [
        ("right", 0.175, 0),
        ("left", 0.175, 1),
        ("right", 0.200, 2),
        ("left", 0.200, 3),
        ("right", 0.200, 4),
    ],
)
def test_forty_degrees_come_out_as_forty(tmp_path: Path, side: Side, length_m: float, seed: int) -> None:
    take = record(tmp_path, side, seed, length_m)
    assert take.measured_share > 0.99
    with SessionReader(take.path) as reader:
        motion = read_motion(reader)
        assert reader.header.side == motion.side == motion.geometry.side == side
    angle = np.where(
        motion.joint_status[:, INDEX_PIP] == Status.MEASURED, motion.joints_rad[:, INDEX_PIP], np.nan
    )
    std = np.sqrt(motion.joint_covariance_rad2[:, INDEX_PIP, INDEX_PIP])
    width = joint_range(motion.t_s, angle, std).width
    assert np.rad2deg(width.value) == pytest.approx(40.0, abs=2.0)
    assert motion.geometry.length_m == pytest.approx(length_m, abs=0.004)


def test_a_take_is_sealed_with_every_capture_and_no_image(tmp_path: Path) -> None:
    take = record(tmp_path, exercise="open_close")
    assert verify(take.path).sha256 == take.sha256
    with SessionReader(take.path) as reader:
        header, counts = reader.header, dict(reader.counts)
        markers = list(reader.records(MARKERS))
    assert counts == {"/markers": 103, "/hand/pose": 103, "/hand/joints": 103, "/tf": 103}
    assert take.frames == 103
    assert take.dropped == 0
    assert header.source == "virtual-camera"
    assert header.subject_id == "P-1"
    assert header.marker_names == PROTOCOL.names
    assert not header.consent_images
    assert len(header.calibration_digest) == 64
    assert np.diff([one.t_ns for one in markers]) == pytest.approx(1e9 / 30, abs=2)
    hidden = {int(status) for one in markers for status in one.status}
    assert hidden == {Status.ESTIMATED, Status.MEASURED}
    assert take.gaps > 0
    assert take.residual_m < 0.001


def test_the_same_seed_gives_the_same_motion(tmp_path: Path) -> None:
    motions = []
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        with SessionReader(record(folder, seed=3).path) as reader:
            motions.append(read_motion(reader).joints_rad)
    assert np.array_equal(*motions)


def test_a_page_sees_every_capture(tmp_path: Path) -> None:
    live: list[LivePose] = []
    camera = virtual_camera("still", "left", 2.0, PROTOCOL)
    record_take(camera, PROTOCOL, order(tmp_path, "left", 1.5), on_frame=live.append)
    assert [one.frame for one in live] == list(range(46))
    states = [one.state for one in live]
    assert states == sorted(states, key=["searching", "calibrating", "tracking"].index)
    assert {"searching", "calibrating", "tracking"} == set(states)
    assert live[0].joints_rad is None
    assert live[-1].state == "tracking"
    assert live[-1].joints_rad is not None
    assert live[-1].geometry is not None
    assert live[-1].quality > 0.9
    image = cv2.imdecode(np.frombuffer(live[-1].jpeg(), np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (480, 640, 3)


def test_a_recording_may_end_early_but_not_before_a_second(tmp_path: Path) -> None:
    seen: list[LivePose] = []
    for frames, kept in ((50, True), (28, False)):
        seen.clear()
        camera = virtual_camera("still", "right", 5.0, PROTOCOL)
        wanted = TakeOrder(tmp_path / f"{frames}.mcap", "right", "still", 5.0, "0.0.0")
        if kept:
            take = record_take(
                camera, PROTOCOL, wanted, on_frame=seen.append, finished=lambda: len(seen) >= 50
            )
            assert take.frames == 50
        else:
            with pytest.raises(Refused, match="record it again, for longer"):
                record_take(camera, PROTOCOL, wanted, on_frame=seen.append, finished=lambda: len(seen) >= 28)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["50.mcap", "50.mcap.sha256"]


def test_without_an_open_hand_there_is_no_take(tmp_path: Path) -> None:
    camera = virtual_camera("still", "right", 2.0, PROTOCOL)
    with pytest.raises(Refused, match="hold it open and still"):
        record_take(camera, PROTOCOL, order(tmp_path, "left", 1.0))
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_leaves_a_recoverable_part_and_no_take(tmp_path: Path) -> None:
    def interrupt(live: LivePose) -> None:
        if live.frame == 45:
            raise KeyboardInterrupt

    camera = virtual_camera("still", "right", 5.0, PROTOCOL)
    with pytest.raises(KeyboardInterrupt):
        record_take(camera, PROTOCOL, order(tmp_path), on_frame=interrupt)
    assert not (tmp_path / "take.mcap").exists()
    assert len(partials(tmp_path)) == 1


def test_a_path_that_is_taken_is_refused_before_the_camera_opens(tmp_path: Path) -> None:
    (tmp_path / "take.mcap").write_bytes(b"precious")
    with pytest.raises(Refused, match="exists"):
        record_take(virtual_camera("still", "right", 2.0, PROTOCOL), PROTOCOL, order(tmp_path))
    assert (tmp_path / "take.mcap").read_bytes() == b"precious"


def test_orders_out_of_bounds_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="another length"):
        order(tmp_path, seconds=0.5)
    with pytest.raises(Refused, match="left or right"):
        TakeOrder(tmp_path / "take.mcap", "both", "still", 2.0, "0.0.0")
