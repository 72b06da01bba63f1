"""Pictures in, tracks out: a session with depth, a video without, an overlay, and what cannot be played."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from rehab_app.cameras import VirtualCamera, virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.overlay import drawn
from rehab_app.recording.recorder import TakeOrder, record_take
from rehab_app.recording.track import track
from rehab_app.recording.track_order import TrackOrder
from sessions.errors import Refused
from sessions.records import Status
from sessions.store import verify

PROTOCOL = load_protocol("thesis25")
SECONDS = 2.4
FRAMES = 73
CAMERA = {"fx": 525, "fy": 525, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480}


def camera() -> VirtualCamera:
    return virtual_camera("open_close", "right", 4.0, PROTOCOL, seed=4, period_s=3.0)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the same hand as an RGB-D session and as a video."""
    folder = tmp_path_factory.mktemp("recorded")
    video = cv2.VideoWriter(str(folder / "hand.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (640, 480))
    record_take(
        camera(),
        PROTOCOL,
        TakeOrder(folder / "hand.mcap", "right", "open_close", SECONDS, "0", consent_images=True),
        on_frame=lambda live: video.write(live.colour_bgr),
    )
    video.release()
    (folder / "camera.json").write_text(json.dumps(CAMERA))
    return folder


def order(source: Path, out: Path, **more: Any) -> TrackOrder:
    return TrackOrder((source,), out, **{"side": "right", "software_version": "0", **more})


def errors_px(tracks: Any) -> np.ndarray:
    """Distance of every visible marker from where it truly is, one row."""
    truth = np.array([camera().truth(float(t)).pixel_px for t in tracks["t_s"]])
    said = np.stack([tracks["u_px"], tracks["v_px"]], axis=2)
    return np.linalg.norm(said - truth, axis=2)[tracks["status"] == Status.MEASURED]


def test_a_session_with_depth_becomes_tracks_and_a_video_over_it(recorded: Path, tmp_path: Path) -> None:
    over = tmp_path / "over.avi"
    result = track(order(recorded / "hand.mcap", tmp_path / "tracks.npz", overlay=over))
    assert (result.frames, result.dropped, result.complaints) == (FRAMES, 0, ())
    with np.load(result.out) as tracks:
        assert np.quantile(errors_px(tracks), 0.95) < 1.0
        found = tracks["detection"]
        given = found >= 0
        assert (tracks["found_frame"][found[given]] == np.nonzero(given)[0]).all()
        assert tracks["found_p_camera_m"].shape == (len(tracks["found_u_px"]), 3)
    drawn_over = cv2.VideoCapture(str(over))
    assert drawn_over.get(cv2.CAP_PROP_FRAME_COUNT) == FRAMES
    drawn_over.release()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["over.avi", "tracks.npz"]


def test_a_video_says_what_is_lost_and_goes_on(recorded: Path, tmp_path: Path) -> None:
    result = track(order(recorded / "hand.avi", tmp_path / "take.mcap", cameras=(recorded / "camera.json",)))
    assert verify(result.out).sha256 == result.sha256
    assert result.frames == FRAMES
    assert "no depth" in result.complaints[0]
    assert result.measured_share > 0.85
    result = track(order(recorded / "hand.avi", tmp_path / "tracks.npz"))
    assert any("not calibrated" in sentence for sentence in result.complaints)


def test_estimates_are_drawn_dashed_and_lost_markers_not_at_all() -> None:
    black = np.zeros((480, 640, 3), np.uint8)
    pixel = np.full((25, 2), np.nan)
    status = np.zeros(25, dtype=np.uint8)
    empty = drawn(black, pixel, status, PROTOCOL)[60:]
    assert not empty.any()
    pixel[8], status[8] = (320.0, 240.0), Status.MEASURED
    whole = drawn(black, pixel, status, PROTOCOL)[60:]
    status[8] = Status.ESTIMATED
    dashed = drawn(black, pixel, status, PROTOCOL)[60:]
    ring = np.s_[230 - 60 : 250 - 60, 310:330]
    assert 0.3 < dashed[ring].any(axis=2).sum() / whole[ring].any(axis=2).sum() < 0.8
    pixel[8] = (1e12, -1e12)  # a wild estimate is left out rather than drawn somewhere
    assert not drawn(black, pixel, status, PROTOCOL)[60:].any()
    assert not black.any()


def test_what_cannot_be_played_is_refused_and_leaves_nothing(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "empty.mp4").write_bytes(b"")
    (tmp_path / "text.mp4").write_text("no video")
    (tmp_path / "small.json").write_text(
        json.dumps({**CAMERA, "width": 320, "height": 240, "cx": 160, "cy": 120})
    )
    before = sorted(path.name for path in tmp_path.iterdir())
    out, video = tmp_path / "tracks.npz", recorded / "hand.avi"
    with pytest.raises(Refused, match="absent"):
        track(order(tmp_path / "absent.mp4", out))
    for name in ("empty.mp4", "text.mp4"):
        with pytest.raises(Refused, match="video"):
            track(order(tmp_path / name, out))
    with pytest.raises(Refused, match="320 x 240"):
        track(order(video, out, cameras=(tmp_path / "small.json",)))
    with pytest.raises(Refused, match="one for each"):
        track(order(video, out, cameras=(recorded / "camera.json",) * 2))
    with pytest.raises(Refused, match="calibrated to each other"):
        track(TrackOrder((video, video), out, "right", "0"))
    with pytest.raises(Refused, match="contrast, histogram"):
        track(order(video, out, detector="guess"))
    with pytest.raises(Refused, match="without a colour"):
        track(order(video, out, protocol="mocap13"))
    with pytest.raises(Refused, match="ending in"):
        order(video, out, overlay=tmp_path / "over.gif")
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_a_video_without_a_hand_is_refused_with_a_reason(tmp_path: Path) -> None:
    path = tmp_path / "dark.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (640, 480))
    for _ in range(40):
        video.write(np.zeros((480, 640, 3), np.uint8))
    video.release()
    with pytest.raises(Refused, match="black"):
        track(order(path, tmp_path / "tracks.npz"))
    assert [one.name for one in tmp_path.iterdir()] == ["dark.avi"]
