from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from rehab_app.cameras.video import VideoCamera
from rehab_app.recording.markerless import bare_hand, track_bare_hand
from rehab_app.recording.pipeline import Pipeline, Seen
from rehab_app.recording.progress import untold
from rehab_app.recording.take import read_motion
from rehab_app.recording.track_order import TrackOrder
from sessions.errors import Refused
from sessions.records import JOINTS, Side, Status
from sessions.records.topics import MARKERS
from sessions.store import SessionReader

START, FRAMES = 240, 70


def written(path: Path, frames: int, pictures: Path | None) -> Path:
    """A small video, out of the real one from where it closes to a fist, or black."""
    source = None if pictures is None else cv2.VideoCapture(str(pictures))
    sink = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 30.0, (640, 360))
    for index in range(START + frames if source else frames):
        image = np.zeros((360, 640, 3), np.uint8) if source is None else source.read()[1]
        if source is None or index >= START:
            sink.write(cv2.resize(image, (640, 360)))
    sink.release()
    return path


@pytest.fixture(scope="module")
def video(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = shared_data / "human_hand_video" / "human_hand_video.mp4"
    return written(tmp_path_factory.mktemp("video") / "hand.mp4", FRAMES, source)


def order(video: Path, out: Path, side: Side = "right") -> TrackOrder:
    return TrackOrder((video,), out, side, "test", protocol="mediapipe21")


def test_a_video_of_a_bare_hand_becomes_a_take(networks: Path, video: Path, tmp_path: Path) -> None:
    result = track_bare_hand(order(video, tmp_path / "take.mcap"), untold, networks)
    assert (result.frames, result.markers, result.protocol) == (FRAMES, 21, "mediapipe21")
    assert result.measured_share > 0.85
    assert result.residual_m < 0.006
    assert any("size is the network's guess" in sentence for sentence in result.complaints)
    with SessionReader(result.out) as reader:
        assert reader.header.marker_protocol == "mediapipe21"
        motion = read_motion(reader)
        places = reader.columns(MARKERS)["p_camera_m"]
    assert motion.side == "right"
    assert 0.15 < motion.geometry.length_m < 0.22
    assert np.isfinite(places).all()
    pip = np.rad2deg(motion.joints_rad[:, JOINTS.index("index_pip")])
    assert np.ptp(pip) > 60.0  # it makes a fist
    assert (motion.joint_status != Status.LOST).all()


def test_the_other_side_is_refused_in_one_sentence(networks: Path, video: Path, tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"looks right in 100 % of the frames.*state --side right"):
        track_bare_hand(order(video, tmp_path / "take.mcap", "left"), untold, networks)
    assert list(tmp_path.iterdir()) == []


def test_a_tracker_of_markers_is_refused(video: Path, tmp_path: Path) -> None:
    wanted = replace(order(video, tmp_path / "take.mcap"), tracker="rbmcda")
    with pytest.raises(Refused, match="tracker is 'rbmcda'"):
        track_bare_hand(wanted, untold)


def test_a_video_without_a_hand_is_refused(networks: Path, tmp_path: Path) -> None:
    black = written(tmp_path / "black.mp4", 40, None)
    with pytest.raises(Refused, match=r"hand in recording black\.mp4 is seen in 0 of 40 frames"):
        track_bare_hand(order(black, tmp_path / "take.mcap"), untold, networks)
    assert [path.name for path in tmp_path.iterdir()] == ["black.mp4"]


def test_a_bare_hand_goes_through_the_live_pipeline(networks: Path, video: Path) -> None:
    detector, tracker = bare_hand("right", metric=False, folder=networks)
    camera = VideoCamera(video)
    with camera:
        seen = [one for one in Pipeline(detector, tracker).run([camera], lambda _: False)]
    tracked = [hand for one in seen if isinstance(one, Seen) for hand in one.tracked]
    assert len(tracked) == FRAMES
    assert tracker.state == "tracking"
    assert all(np.isfinite(hand.pose.joints_rad).all() for hand in tracked)
