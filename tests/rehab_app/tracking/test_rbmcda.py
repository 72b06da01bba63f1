"""What stands around the association filter: depth, the camera read off rays, the start, the pose behind."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from rehab_app.hand.protocol import load_protocol
from rehab_app.tracking import Labels, TrackedHand
from rehab_app.tracking.rbmcda import RbmcdaTracker
from rehab_app.tracking.rbmcda_depth import DepthMemory, pinhole_of
from rehab_app.tracking.rbmcda_image import ImageTracks
from rehab_app.tracking.rbmcda_settings import RBMCDA
from sessions.records import Status
from sessions.records.fields import Float64

PROTOCOL = load_protocol("thesis25")


def seen_at(pixel_px: Float64, depth_m: Float64, t_ns: int = 0, camera: Intrinsics = KINECT) -> Detections:
    count = len(pixel_px)
    return lifted(
        t_ns,
        pixel_px,
        depth_m,
        camera,
        pixel_std_px=np.full(count, 0.5),
        depth_std_m=np.full(count, 0.001),
        similarity=np.ones(count),
    )


@cache
def sequence_of(level: str, seed: int, frames: int) -> PointSequence:
    return point_sequence(level, seed, frames)


def labels_of(sequence: PointSequence) -> Labels:
    return Labels(sequence.protocol.names, sequence.init_pixel_px)


def depthless(one: Detections) -> Detections:
    return replace(
        one,
        p_camera_m=np.full_like(one.p_camera_m, np.nan),
        covariance_m2=np.full_like(one.covariance_m2, np.nan),
    )


def follow(tracker: RbmcdaTracker, captures: list[Detections]) -> list[TrackedHand]:
    return [hand for one in captures for hand in tracker.observe(one)]


# --- the camera read off rays ---


def test_pixels_and_rays_tell_the_camera() -> None:
    camera = Intrinsics(600.0, 580.0, 300.0, 250.0, 640, 480)
    pixel = np.random.default_rng(0).uniform(100.0, 400.0, (12, 2))
    found = pinhole_of(seen_at(pixel, np.full(12, np.nan), camera=camera), (640, 480))
    assert found is not None
    numbers = [found.fx_px, found.fy_px, found.cx_px, found.cy_px]
    assert numbers == pytest.approx([600.0, 580.0, 300.0, 250.0], abs=1e-6)


@pytest.mark.parametrize("pixel", [np.empty((0, 2)), np.array([[9.0, 9.0]]), np.full((5, 2), 50.0)])
def test_too_few_or_coincident_pixels_tell_nothing(pixel: Float64) -> None:
    assert pinhole_of(seen_at(pixel, np.full(len(pixel), 0.7)), (640, 480)) is None


# --- depth ---


def test_a_depth_far_off_the_last_is_not_the_markers() -> None:
    memory, markers = DepthMemory(3), np.arange(3)
    first = np.array([0.70, 0.71, 0.69])
    assert memory.credible(markers, first, 1.0).tolist() == [0, 1, 2]
    memory.remember(markers, first, np.full(3, 0.001))
    assert memory.credible(markers, np.array([0.71, 1.4, np.nan]), 1.0).tolist() == [0]


def test_a_depth_that_insists_is_believed_in_the_end() -> None:
    memory, marker = DepthMemory(1), np.array([0])
    memory.remember(marker, np.array([0.4]), np.array([0.001]))
    tries = [len(memory.credible(marker, np.array([0.7]), 1.0)) for _ in range(10)]
    assert tries[0] == 0
    assert tries[-1] == 1


def test_of_unknown_markers_the_one_away_from_the_hand_is_doubted() -> None:
    depths = np.array([0.70, 0.71, 0.69, 1.5, 0.72])
    assert DepthMemory(5).credible(np.arange(5), depths, 1.0).tolist() == [0, 1, 2, 4]


def test_a_marker_without_depth_of_its_own_keeps_the_last_and_says_how_unsure() -> None:
    pixel = np.array([[300.0, 200.0], [350.0, 260.0], [320.0, 300.0]])
    tracks = ImageTracks(RBMCDA, 3, 0)
    tracks.place(np.arange(3), pixel)
    first = tracks.follow(seen_at(pixel, np.full(3, 0.7)))
    hole = np.array([0.7, np.nan, 0.7])
    second = tracks.follow(seen_at(pixel, hole, 33_000_000))
    assert second.status.tolist() == [Status.MEASURED] * 3
    assert second.p_camera_m[1] == pytest.approx(KINECT.lift(pixel[1], np.float64(0.7)), abs=1e-6)
    assert second.covariance_m2[1, 2, 2] > 10 * first.covariance_m2[1, 2, 2]
    assert second.covariance_m2[0, 2, 2] == pytest.approx(first.covariance_m2[0, 2, 2])


def test_an_unseen_marker_is_an_estimate_for_half_a_second_and_then_lost() -> None:
    pixel = np.array([[300.0, 200.0], [350.0, 260.0], [320.0, 300.0]])
    tracks = ImageTracks(RBMCDA, 3, 0)
    tracks.place(np.arange(3), pixel)
    tracks.follow(seen_at(pixel, np.full(3, 0.7)))
    spread: list[float] = []
    for index in range(1, 30):
        frame = tracks.follow(seen_at(pixel[:2], np.full(2, 0.7), index * 33_333_333))
        assert frame.status[:2].tolist() == [Status.MEASURED] * 2
        late = index * 33_333_333 > 500_000_000
        assert frame.status[2] == (Status.LOST if late else Status.ESTIMATED)
        assert np.isfinite(frame.p_camera_m[2]).all() == (not late)
        spread.append(float(frame.covariance_m2[2, 0, 0]))
    assert (np.diff(spread[:14]) > 0).all(), "the longer unseen, the less sure"
    back = tracks.follow(seen_at(pixel, np.full(3, 0.7), 30 * 33_333_333))
    assert back.status[2] == Status.MEASURED


# --- start, loss, pose ---


def test_an_open_hand_without_depth_is_named_by_its_layout() -> None:
    sequence = sequence_of("easy", 11, 40)
    tracker = RbmcdaTracker(PROTOCOL, "right")
    captures = [depthless(one) for one in sequence.detections]
    hands = follow(tracker, captures)
    assert len(hands) == len(captures)
    for frame, hand in enumerate(hands):
        marker = np.flatnonzero(hand.detection >= 0)
        assert (sequence.owner[frame][hand.detection[marker]] == marker).mean() > 0.9
        assert np.isnan(hand.pose.joints_rad).all()
        assert np.isnan(hand.markers.p_camera_m).all()
    assert tracker.subject is None
    assert tracker.complaint is not None
    assert "no depth" in tracker.complaint


def test_depth_that_comes_later_brings_the_pose() -> None:
    sequence = sequence_of("easy", 12, 60)
    captures = [depthless(one) if k < 10 else one for k, one in enumerate(sequence.detections)]
    tracker = RbmcdaTracker(PROTOCOL, "right", labels=labels_of(sequence))
    hands = follow(tracker, captures)
    assert len(hands) == 60
    assert np.isnan(hands[5].pose.joints_rad).all()
    assert np.isfinite(hands[-1].pose.joints_rad).all()
    assert tracker.complaint is None


def test_a_known_person_is_not_learnt_again_and_nothing_is_held_back() -> None:
    sequence = sequence_of("easy", 13, 60)
    first = RbmcdaTracker(PROTOCOL, "right", labels=labels_of(sequence))
    follow(first, list(sequence.detections))
    assert first.subject is not None
    again = RbmcdaTracker(PROTOCOL, "right", first.subject)
    counts = [len(again.observe(one)) for one in sequence.detections]
    assert counts == [1] * 60
    assert again.subject is first.subject
    assert again.state == "tracking"


def test_labelled_captures_come_back_with_the_pose_that_was_learnt_from_them() -> None:
    sequence = sequence_of("easy", 14, 30)
    tracker = RbmcdaTracker(PROTOCOL, "right", labels=labels_of(sequence))
    counts = [len(tracker.observe(one)) for one in sequence.detections]
    assert sum(counts) == 30
    assert counts[0] == 0
    assert tracker.state == "tracking"
    hands = follow(RbmcdaTracker(PROTOCOL, "right", labels=labels_of(sequence)), list(sequence.detections))
    assert all(np.isfinite(hand.pose.joints_rad).all() for hand in hands)
    error = np.abs(hands[0].pose.joints_rad - sequence.joints_rad[0])
    assert np.median(error) < np.deg2rad(5.0)


def test_markers_that_nobody_named_are_found_from_the_fitted_hand() -> None:
    sequence = sequence_of("easy", 15, 60)
    kept = np.setdiff1d(np.arange(25), [3, 10])
    labels = Labels(tuple(PROTOCOL.names[k] for k in kept), sequence.init_pixel_px[kept])
    tracker = RbmcdaTracker(PROTOCOL, "right", labels=labels)
    hands = follow(tracker, list(sequence.detections))
    assert (hands[0].markers.status[[3, 10]] == Status.LOST).all()
    last = hands[-1].detection[[3, 10]]
    assert (last >= 0).all()
    assert sequence.owner[-1][last].tolist() == [3, 10]


def test_joints_follow_the_truth_while_names_are_right() -> None:
    sequence = sequence_of("easy", 16, 90)
    hands = follow(RbmcdaTracker(PROTOCOL, "right", labels=labels_of(sequence)), list(sequence.detections))
    joints = np.array([hand.pose.joints_rad for hand in hands])
    error = np.abs(joints - sequence.joints_rad)
    assert np.nanmedian(error) < np.deg2rad(4.0)
    measured = np.array([hand.markers.status == Status.MEASURED for hand in hands])
    points = np.array([hand.markers.p_camera_m for hand in hands])
    apart = np.linalg.norm(points - sequence.p_camera_m, axis=2)[measured]
    assert np.median(apart) < 0.002
