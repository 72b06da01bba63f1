"""Recorded sessions and videos as cameras: what goes in comes out; what cannot be used is one sentence."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rehab_app.cameras import CLEAN, Frame, RecordedCamera, VideoCamera, open_camera, virtual_camera
from rehab_app.cameras import video as video_source
from rehab_app.cameras.nominal import assumed
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.images import calibration_record, frame_records, millimetres
from sessions.errors import Refused
from sessions.records import SessionHeader
from sessions.records.topics import CAMERA_CALIBRATION, CAMERA_COLOUR, CAMERA_DEPTH
from sessions.store import SessionReader, SessionWriter, verify

HEADER = SessionHeader(
    session_id="d" * 32,
    kind="take",
    subject_id="p-1",
    side="left",
    exercise="tapping",
    source="virtual-camera",
    software_version="0",
    utc_start_ns=1_790_000_000_123_456_789,
    monotonic_start_ns=42,
    consent_images=True,
)


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    camera = virtual_camera("open_close", "right", 3.0, load_protocol("thesis25"), noise=CLEAN)
    return [replace(camera.frame(index), t_capture_ns=camera.time_ns(index) + 7) for index in range(5)]


@pytest.fixture(scope="module")
def session(frames: list[Frame], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("session") / "take.mcap"
    with SessionWriter(path, HEADER) as writer:
        for index, frame in enumerate(frames):
            for topic, record in frame_records(frame, calibration=index == 0):
                writer.write(topic, record)
        writer.seal()
    return path


def video(path: Path, count: int, code: str = "MJPG", size: tuple[int, int] = (320, 240)) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), 20.0, size)
    for index in range(count):
        writer.write(np.full((size[1], size[0], 3), (10 * index, 60, 160), np.uint8))
    writer.release()
    return path


def test_a_session_gives_back_times_depth_and_camera_exactly(frames: list[Frame], session: Path) -> None:
    verify(session)
    with RecordedCamera(session) as camera:
        back = list(camera.frames())
    assert [frame.t_capture_ns for frame in back] == [frame.t_capture_ns for frame in frames]
    assert camera.intrinsics == frames[0].intrinsics
    assert camera.rate_hz == pytest.approx(30.0, rel=1e-6)
    assert camera.has_depth
    for one, other in zip(frames, back, strict=True):
        assert np.abs(one.depth_m - other.depth_m).max() <= 0.0005001  # rounded to whole millimetres
        error = one.colour_bgr.astype(int) - other.colour_bgr.astype(int)
        assert np.sqrt(np.mean(error**2)) < 3.0  # JPEG, of 255


def test_markers_keep_their_colour_through_the_file(frames: list[Frame], session: Path) -> None:
    blue = frames[0].colour_bgr[..., 0].astype(int) - frames[0].colour_bgr[..., 2]
    with RecordedCamera(session) as camera:
        back = next(camera.frames()).colour_bgr
    kept = back[..., 0].astype(int) - back[..., 2]
    assert np.median(kept[blue > 120] / blue[blue > 120]) == pytest.approx(1.0, abs=0.03)


@given(st.lists(st.floats(0.0, 60.0), min_size=1, max_size=20))
def test_millimetres_round_to_the_nearest(depth: list[float]) -> None:
    depth_m = np.array([depth], np.float32)
    assert np.abs(millimetres(depth_m) / 1000.0 - depth_m).max() <= 0.000504


def test_what_is_no_depth_becomes_zero() -> None:
    strange = np.array([[np.nan, np.inf, -1.0, 70.0, 0.0]], np.float32)
    assert millimetres(strange).tolist() == [[0, 0, 0, 0, 0]]


def test_images_need_consent_and_the_camera_does_not(frames: list[Frame], tmp_path: Path) -> None:
    path = tmp_path / "take.mcap"
    with SessionWriter(path, replace(HEADER, consent_images=False)) as writer:
        writer.write(CAMERA_CALIBRATION, calibration_record(frames[0]))
        for topic, record in frame_records(frames[0]):
            assert topic in (CAMERA_COLOUR, CAMERA_DEPTH)
            with pytest.raises(Refused, match="consent"):
                writer.write(topic, record)
        writer.seal()
    with SessionReader(path) as reader:
        assert reader.counts == {"/camera/calibration": 1}
    with pytest.raises(Refused, match="without images"):
        RecordedCamera(path)


def test_a_frame_without_depth_is_recorded_as_such(frames: list[Frame]) -> None:
    topics = [topic for topic, _ in frame_records(replace(frames[0], depth_m=None), calibration=True)]
    assert topics == [CAMERA_CALIBRATION, CAMERA_COLOUR]


def test_a_video_keeps_rate_order_and_pictures(tmp_path: Path) -> None:
    with VideoCamera(video(tmp_path / "a.avi", 9)) as camera:
        back = list(camera.frames())
    assert [frame.t_capture_ns for frame in back] == [50_000_000 * index for index in range(9)]
    assert [round(frame.colour_bgr[..., 0].mean(), -1) for frame in back] == [10 * i for i in range(9)]
    assert camera.intrinsics == assumed(320, 240)
    assert camera.intrinsics_assumed
    assert not camera.has_depth


class Container:
    """A video as OpenCV shows it, 25 Hz, with times that begin late, stall and skip."""

    times_ms = (1000.0, 1040.0, 1040.0, 1120.0, 1240.0)

    def __init__(self) -> None:
        self._count = 0

    def read(self) -> tuple[bool, np.ndarray | None]:
        self._count += 1
        more = self._count <= len(self.times_ms)
        return more, np.zeros((48, 64, 3), np.uint8) if more else None

    def get(self, key: int) -> float:
        at = self.times_ms[min(self._count, len(self.times_ms)) - 1]
        return {cv2.CAP_PROP_POS_MSEC: at, cv2.CAP_PROP_FPS: 25.0, cv2.CAP_PROP_FRAME_COUNT: 5.0}[key]

    def release(self) -> None:
        return


def test_times_are_the_container_s_and_rise(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video_source, "_opened", lambda _: Container())
    with VideoCamera(Path("any.mp4")) as camera:
        frames = list(camera.frames())
    assert [frame.t_capture_ns // 10**6 for frame in frames] == [0, 40, 80, 120, 240]
    assert [frame.dropped for frame in frames] == [0, 0, 0, 0, 2]


def test_a_telephone_s_video_keeps_its_times(shared_data: Path) -> None:
    with VideoCamera(shared_data / "human_hand_video" / "human_hand_video.mp4") as camera:
        times = [frame.t_capture_ns for frame in islice(camera.frames(), 20)]
    assert (camera.frame_count, camera.rate_hz) == (621, 30.0)
    assert (camera.intrinsics.width_px, camera.intrinsics.height_px) == (1280, 720)
    assert np.diff(times) == pytest.approx(1e9 / 30.0, abs=1.0)


def test_the_assumed_camera_sees_sixty_degrees() -> None:
    lens = assumed(640, 480)
    left, right = (lens.lift(np.array([u, 0.0]), np.array(1.0))[0] for u in (-0.5, 639.5))
    assert np.degrees(np.arctan(right) - np.arctan(left)) == pytest.approx(60.0)


def test_a_cut_video_is_told_at_its_end(tmp_path: Path) -> None:
    whole = video(tmp_path / "whole.avi", 60)
    cut = tmp_path / "cut.avi"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    with pytest.raises(Refused, match=r"cut|not readable"), VideoCamera(cut) as camera:
        list(camera.frames())


def test_unusable_files_are_sentences(
    tmp_path: Path, session: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    noise, empty, bare = tmp_path / "noise.mp4", tmp_path / "empty.mp4", tmp_path / "bare.avi"
    noise.write_bytes(bytes(range(256)) * 40)
    empty.touch()
    video(bare, 0)
    capfd.readouterr()
    for path, words in (
        (noise, "not readable as a video"),
        (empty, "is empty"),
        (bare, r"without frames|not readable"),
        (tmp_path / "absent.mp4", "is absent"),
        (tmp_path, "is a folder"),
    ):
        with pytest.raises(Refused, match=words):
            VideoCamera(path)
    assert capfd.readouterr() == ("", "")  # the sentence is all that is said
    with pytest.raises(Refused, match="no MCAP file"):
        open_camera(f"session:{noise}")
    other = Intrinsics(500.0, 500.0, 160.0, 120.0, 320, 240)
    with pytest.raises(Refused, match="320 x 240 px, but must be 640 x 480 px"):
        RecordedCamera(session, other)


def test_images_that_are_no_images_are_a_sentence(frames: list[Frame], tmp_path: Path) -> None:
    path = tmp_path / "take.mcap"
    with SessionWriter(path, HEADER) as writer:
        for topic, record in frame_records(frames[0], calibration=True):
            broken = replace(record, encoded=record.encoded[:50]) if topic is CAMERA_COLOUR else record
            writer.write(topic, broken)
        writer.seal()
    with pytest.raises(Refused, match="not readable"):
        RecordedCamera(path)
