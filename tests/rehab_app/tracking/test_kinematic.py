"""The kinematic tracker on detections drawn from the truth: identity, loss, return, honesty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from rehab_app.cameras import Truth, VirtualCamera, virtual_camera
from rehab_app.geometry.detections import Detections, lifted
from rehab_app.hand.protocol import load_protocol
from rehab_app.tracking import KinematicTracker, TrackedHand
from sessions.records import JOINTS, LANDMARKS, Side, Status
from sessions.records.fields import Float64, Int64

PROTOCOL = load_protocol("thesis25")
TIPS = [LANDMARKS.index(f"{digit}_tip") for digit in ("thumb", "index", "middle", "ring", "little")]


@dataclass(frozen=True)
class Capture:
    detections: Detections
    owner: Int64  # marker that each detection is of, -1 for clutter


@cache
def truth_of(camera: VirtualCamera, index: int) -> Truth:
    return camera.truth(index / 30)


def capture(
    camera: VirtualCamera, index: int, rng: np.random.Generator, miss: float, clutter: float
) -> Capture:
    truth = truth_of(camera, index)
    seen = (
        (truth.seen > 0.6)
        & (truth.markers.facing() > 0.25)
        & (rng.random(25) > (miss if index > 25 else 0.0))
    )
    owner = np.flatnonzero(seen)
    pixel = truth.pixel_px[owner] + rng.normal(0.0, 0.1, (len(owner), 2))
    depth = truth.markers.p_camera_m[owner, 2] + rng.normal(0.0, 0.0006, len(owner))
    extra = rng.poisson(clutter)
    pixel = np.vstack([pixel, truth.pixel_px.mean(axis=0) + rng.uniform(-70, 70, (extra, 2))])
    depth = np.concatenate([depth, rng.uniform(0.62, 0.74, extra)])
    order = rng.permutation(len(depth))
    pixel, depth = pixel[order], depth[order]
    owner = np.concatenate([owner, np.full(extra, -1)])[order]
    return Capture(lifted_at(camera, index, pixel, depth), owner)


def lifted_at(camera: VirtualCamera, index: int, pixel_px: Float64, depth_m: Float64) -> Detections:
    count = len(depth_m)
    return lifted(
        camera.time_ns(index),
        pixel_px,
        depth_m,
        camera.intrinsics,
        pixel_std_px=np.full(count, 0.1),
        depth_std_m=np.full(count, 0.0006),
        similarity=np.ones(count),
    )


def blank(camera: VirtualCamera, index: int) -> Capture:
    return Capture(lifted_at(camera, index, np.empty((0, 2)), np.empty(0)), np.empty(0, np.int64))


def follow(tracker: KinematicTracker, captures: Sequence[Capture]) -> list[TrackedHand]:
    return [hand for one in captures for hand in tracker.observe(one.detections)]


@cache
def captures_of(
    exercise: str,
    side: Side = "right",
    seed: int = 0,
    miss: float = 0.0,
    clutter: float = 0.0,
    frames: int = 98,
) -> tuple[VirtualCamera, tuple[Capture, ...]]:
    camera = virtual_camera(exercise, side, 3.4, PROTOCOL, seed=seed, period_s=2.0)
    rng = np.random.default_rng([seed, 9])
    return camera, tuple(capture(camera, index, rng, miss, clutter) for index in range(frames))


def wrong(hands: list[TrackedHand], captures: Sequence[Capture]) -> int:
    """How often a label sat on another marker's blob or on clutter."""
    count = 0
    for hand, one in zip(hands, captures, strict=True):
        given = hand.detection >= 0
        count += int((one.owner[hand.detection[given]] != np.flatnonzero(given)).sum())
    return count


@pytest.mark.parametrize(
    ("exercise", "side"), [("open_close", "right"), ("tapping", "left"), ("pinch", "left")]
)
def test_no_marker_ever_carries_another_ones_name(exercise: str, side: Side) -> None:
    _, captures = captures_of(exercise, side)
    hands = follow(KinematicTracker(PROTOCOL, side), captures)
    assert [hand.markers.t_ns for hand in hands] == [one.detections.t_capture_ns for one in captures]
    assert wrong(hands, captures) == 0
    seen = sum(len(one.owner) for one in captures)
    given = sum(int((hand.detection >= 0).sum()) for hand in hands)
    assert given > 0.99 * seen


def test_misses_and_clutter_cost_little() -> None:
    _, captures = captures_of("open_close", seed=1, miss=0.03, clutter=1.5)
    hands = follow(KinematicTracker(PROTOCOL, "right"), captures)
    labels = sum(int((hand.detection >= 0).sum()) for hand in hands)
    assert wrong(hands, captures) < 0.005 * labels


def test_fingertips_and_joints_follow_the_truth() -> None:
    camera, captures = captures_of("open_close", seed=2)
    hands = follow(KinematicTracker(PROTOCOL, "right"), captures)
    index_pip = JOINTS.index("index_pip")
    errors, measured, estimated = [], [], []
    for index, hand in enumerate(hands):
        truth = truth_of(camera, index)
        errors.append(hand.pose.joints_rad[index_pip] - truth.joints_rad[index_pip])
        # markers, the visible part of a fingertip, against their true places
        distance = np.linalg.norm(hand.markers.p_camera_m - truth.markers.p_camera_m, axis=1)[TIPS]
        measured += list(distance[hand.markers.status[TIPS] == Status.MEASURED])
        estimated += list(distance[hand.markers.status[TIPS] == Status.ESTIMATED])
    assert np.std(errors) < np.deg2rad(2.0)
    assert np.sqrt(np.mean(np.square(measured))) < 0.0015
    assert len(estimated) > 20  # fingertips turn away in this exercise
    assert np.sqrt(np.mean(np.square(estimated))) < 0.006


def test_hidden_markers_are_estimates_with_a_larger_covariance() -> None:
    _, captures = captures_of("open_close")
    hands = follow(KinematicTracker(PROTOCOL, "right"), captures)
    tip = LANDMARKS.index("middle_tip")
    hidden = [hand for hand in hands if hand.markers.status[tip] == Status.ESTIMATED]
    shown = [hand for hand in hands if hand.markers.status[tip] == Status.MEASURED]
    assert hidden
    assert all(np.isnan(hand.markers.pixel_px[tip]).all() for hand in hidden)
    spread = [np.mean([np.trace(h.markers.covariance_m2[tip]) for h in group]) for group in (hidden, shown)]
    assert spread[0] > 4 * spread[1]
    dip = JOINTS.index("middle_dip")
    assert all(hand.pose.joint_status[dip] == Status.ESTIMATED for hand in hidden)


def test_the_order_of_detections_means_nothing() -> None:
    _, captures = captures_of("pinch", frames=60)
    rng = np.random.default_rng(0)
    shuffled: list[Capture] = []
    for one in captures:
        order = rng.permutation(len(one.owner))
        detections = one.detections.rows(order)
        shuffled.append(Capture(detections, one.owner[order]))
    one, other = (follow(KinematicTracker(PROTOCOL, "right"), group)[-1] for group in (captures, shuffled))
    assert other.pose.joints_rad == pytest.approx(one.pose.joints_rad, abs=1e-5)


def test_a_blank_is_a_gap_and_a_lost_hand_is_found_again() -> None:
    camera, taken = captures_of("still", frames=90)
    captures = list(taken)
    for index in range(40, 43):
        captures[index] = blank(camera, index)
    for index in range(55, 75):
        captures[index] = blank(camera, index)
    tracker = KinematicTracker(PROTOCOL, "right")
    hands = follow(tracker, captures[:70])
    assert tracker.state == "lost"
    assert tracker.expected_m is None
    hands += follow(tracker, captures[70:])
    assert tracker.state == "tracking"
    assert (hands[41].markers.status == Status.ESTIMATED).all()
    assert np.isfinite(hands[41].pose.joints_rad).all()
    assert (hands[41].pose.joint_status == Status.ESTIMATED).all()
    for index in (60, 74):
        assert (hands[index].markers.status == Status.LOST).all()
        assert np.isnan(hands[index].pose.joints_rad).all()
        assert (hands[index].pose.joint_status == Status.LOST).all()
    assert wrong(hands, captures) == 0
    assert all((hand.detection >= 0).sum() >= 24 for hand in hands[75:])


def test_until_a_hand_is_seen_nothing_is_understood() -> None:
    camera, captures = captures_of("still", frames=40)
    tracker = KinematicTracker(PROTOCOL, "right")
    assert tracker.state == "searching"
    assert follow(tracker, [blank(camera, index) for index in range(5)]) == []
    assert follow(tracker, captures[5:15]) == []
    assert tracker.state == "calibrating"
    hands = follow(tracker, captures[15:40])
    assert len(hands) == 40  # the five blank ones and all that was held back
    assert (hands[2].markers.status == Status.LOST).all()
    assert tracker.subject is not None
    assert tracker.subject.geometry.length_m == pytest.approx(0.185, abs=0.004)


def test_the_other_hand_is_not_taken_for_this_one() -> None:
    _, captures = captures_of("still", "left", frames=30)
    tracker = KinematicTracker(PROTOCOL, "right")
    assert follow(tracker, captures[::6]) == []
    assert tracker.state == "searching"


def test_memory_of_a_long_wait_is_bounded() -> None:
    camera, captures = captures_of("still", frames=30)
    tracker = KinematicTracker(PROTOCOL, "right")
    assert follow(tracker, [blank(camera, index) for index in range(600)]) == []
    later = [
        Capture(replace(one.detections, t_capture_ns=camera.time_ns(600 + index)), one.owner)
        for index, one in enumerate(captures)
    ]
    assert 450 <= len(follow(tracker, later)) <= 470
