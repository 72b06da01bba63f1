"""Detections in, tracks or a take out: a row for every frame, names on their markers, nothing half-made."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.cameras.sequence_file import write_detections_npz
from rehab_app.recording.take import read_motion
from rehab_app.recording.track import track
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.recording.tracks import COAST, Tracks
from sessions.errors import Refused
from sessions.records import JOINTS, Status
from sessions.records.topics import MARKERS
from sessions.store import SessionReader, verify

FRAMES = 120


@pytest.fixture(scope="module")
def sequence() -> PointSequence:
    return point_sequence("medium", 31, FRAMES)


@pytest.fixture
def points(sequence: PointSequence, tmp_path: Path) -> Path:
    path = tmp_path / "points.npz"
    write_detections_npz(sequence, path)
    return path


def order(points: Path, out: str = "tracks.npz", **more: Any) -> TrackOrder:
    return TrackOrder((points,), points.with_name(out), **{"side": "right", "software_version": "0", **more})


def respelled(points: Path, **arrays: Any) -> Path:
    content = {**np.load(points), **arrays}
    np.savez(points, **{name: value for name, value in content.items() if value is not None})
    return points


def owners(sequence: PointSequence) -> np.ndarray:
    return np.concatenate(sequence.owner)


def test_every_frame_has_a_row_and_every_name_its_marker(sequence: PointSequence, points: Path) -> None:
    result = track(order(points))
    with np.load(result.out) as made, np.load(points) as given:
        tracks, given_frame = dict(made), given["frame"]
        assert made["t_s"] == pytest.approx(given["frame_t_s"])
    assert tuple(tracks["marker"]) == sequence.protocol.names
    shape = (FRAMES, len(sequence.protocol.names))
    for name in ("u_px", "v_px", "visible", "detection"):
        assert tracks[name].shape == shape
    assert tracks["p_camera_m"].shape == (*shape, 3)
    assert tracks["joints_rad"].shape == (FRAMES, len(JOINTS))
    frame, marker = np.nonzero(tracks["detection"] >= 0)
    row = tracks["detection"][frame, marker]
    assert (given_frame[row] == frame).all()
    assert len(set(row.tolist())) == len(row)  # nothing was given to two markers
    assert np.mean(owners(sequence)[row] == marker) > 0.99
    pixel = np.stack([tracks["u_px"], tracks["v_px"]], axis=2)
    apart = np.linalg.norm(pixel - sequence.pixel_px, axis=2)[tracks["visible"] & sequence.visible]
    assert np.sqrt(np.mean(apart**2)) < 2.0
    assert result.frames == FRAMES
    assert result.measured_share + result.estimated_share + result.lost_share == pytest.approx(1.0)
    assert result.complaints == ()


def test_the_order_of_the_rows_does_not_matter(points: Path) -> None:
    first = track(order(points))
    with np.load(points) as given:
        shuffled = np.random.default_rng(1).permutation(len(given["frame"]))
        changed = {name: given[name][shuffled] for name in ("frame", "u_px", "v_px", "depth_m")}
    second = track(order(respelled(points, **changed), "again.npz"))
    with np.load(first.out) as one, np.load(second.out) as other:
        mapped = np.where(other["detection"] >= 0, shuffled[other["detection"]], -1)
        assert np.mean(mapped == one["detection"]) > 0.999
        assert np.nanmedian(np.abs(other["p_camera_m"] - one["p_camera_m"])) < 1e-6


def test_a_take_states_every_frame_too(sequence: PointSequence, points: Path) -> None:
    result = track(order(points, "take.mcap", exercise="mixed", subject_id="T-1"))
    assert verify(result.out).sha256 == result.sha256
    with SessionReader(result.out) as reader:
        assert reader.header.exercise == "mixed"
        assert reader.header.subject_id == "T-1"
        assert reader.header.source == "detections-npz"
        assert reader.header.marker_names == sequence.protocol.names
        assert reader.counts[MARKERS.name] == FRAMES
        motion = read_motion(reader)
    assert motion.t_s[-1] == pytest.approx((FRAMES - 1) / 30.0)


def test_the_protocol_is_recognised_by_the_labels(points: Path) -> None:
    assert track(order(points)).protocol == "thesis25"
    with pytest.raises(Refused, match=r"naming cmc4.*markers of fingertips5"):
        track(order(points, "other.npz", protocol="fingertips5"))


def test_unnamed_markers_and_names_that_point_at_nothing_are_told(points: Path) -> None:
    with np.load(points) as given:
        names, u, v = given["init_name"], given["init_u_px"].copy(), given["init_v_px"].copy()
    u[3] = v[3] = 2.0
    result = track(order(respelled(points, init_name=names[:20], init_u_px=u[:20], init_v_px=v[:20])))
    unnamed, alone = result.complaints[:2]
    assert all(name in unnamed for name in names[20:])
    assert alone.endswith(f": {names[3]}.")


def test_a_known_hand_is_taken(points: Path) -> None:
    from rehab_app.recording.track_subject import subject_of

    take = track(order(points, "take.mcap"))
    known = subject_of(take.out)
    result = track(order(points, "tracks.npz", subject=known))
    assert result.measured_share == pytest.approx(take.measured_share, abs=0.02)
    with pytest.raises(Refused, match="exists"):
        subject_of(points.with_name("absent.mcap"))


def nothing_made(points: Path) -> bool:
    return sorted(path.name for path in points.parent.iterdir()) == [points.name]


@pytest.mark.parametrize("out", ["tracks.npz", "take.mcap"])
def test_an_interruption_leaves_nothing(points: Path, out: str) -> None:
    def interrupt(done: int, total: int | None) -> None:
        assert total == FRAMES
        if done == 100:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        track(order(points, out), interrupt)
    assert nothing_made(points)


@pytest.mark.parametrize("out", ["tracks.npz", "take.mcap"])
def test_a_recording_without_a_hand_is_refused_and_leaves_nothing(points: Path, out: str) -> None:
    rng = np.random.default_rng(0)
    with np.load(points) as given:
        count = len(given["frame"])
    clutter = {
        "u_px": rng.uniform(0, 640, count),
        "v_px": rng.uniform(0, 480, count),
        "init_name": None,
        "init_u_px": None,
        "init_v_px": None,
    }
    with pytest.raises(Refused, match="without a hand that could be understood"):
        track(order(respelled(points, **clutter), out))
    assert nothing_made(points)


def test_orders_that_make_no_sense_are_refused(points: Path) -> None:
    with pytest.raises(Refused, match="left or right"):
        order(points, side="both")
    with pytest.raises(Refused, match=r"\.npz or \.mcap"):
        order(points, "tracks.csv")
    with pytest.raises(Refused, match="exists"):
        order(points, points.name)
    with pytest.raises(Refused, match="existing folder"):
        TrackOrder((points,), points.parent / "no" / "tracks.npz", "right", "0")
    with pytest.raises(Refused, match="no pictures"):
        track(order(points, overlay=points.with_name("over.mp4")))
    with pytest.raises(Refused, match="kinematic, rbmcda"):
        track(order(points, tracker="magic"))
    with pytest.raises(Refused, match="one file of detections"):
        track(replace(order(points), inputs=(points, points)))
    assert nothing_made(points)


def test_a_marker_counts_as_seen_for_three_captures_after_its_last_detection() -> None:
    measured, estimated, lost = (int(one) for one in (Status.MEASURED, Status.ESTIMATED, Status.LOST))
    one = [measured] + [estimated] * 5 + [measured, lost, estimated]
    status = np.array([one, [measured] * len(one)], dtype=np.uint8).T
    frames, markers = status.shape
    nothing = np.zeros((frames, markers, 2))
    made = Tracks(("a", "b"), nothing, nothing, status, nothing, nothing, nothing, nothing, status)
    assert COAST == 3
    assert made.visible[:, 0].tolist() == [True, True, True, True, False, False, True, False, True]
    assert made.visible[:, 1].all()


def test_figures_are_those_of_the_file(points: Path) -> None:
    result: TrackResult = track(order(points))
    with np.load(result.out) as made:
        assert result.measured_share == pytest.approx(np.mean(made["status"] == Status.MEASURED))
        assert result.lost_share == pytest.approx(np.mean(made["status"] == Status.LOST))
        lost = made["status"] == Status.LOST
        assert np.isnan(made["u_px"][lost]).all()
        assert np.isfinite(made["u_px"][~lost]).all()
        assert not made["visible"][lost].any()
