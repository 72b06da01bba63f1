"""What every tracker must do when something is missing: captures, time, depth, the hand itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.geometry.detections import joined
from rehab_app.tracking import TRACKERS
from sessions.records import Status
from tests.contracts.tracker_checks import (
    Make,
    blank,
    check,
    follow,
    maker,
    received,
    right_names,
    sequence_of,
    without_depth,
)


@pytest.fixture(params=TRACKERS)
def make(request: pytest.FixtureRequest) -> Make:
    """Makes a tracker for a sequence; see ``maker``."""
    return maker(request.param)


def test_until_an_open_hand_is_seen_captures_are_held_back(make: Make) -> None:
    sequence = sequence_of("easy")
    captures = received(sequence)
    tracker = make(sequence, labelled=False)
    assert tracker.state == "searching"
    assert tracker.subject is None
    assert tracker.expected_m is None
    start = captures[0].t_capture_ns
    early = [blank(start - (12 - k) * 33_000_000, captures[0]) for k in range(12)]
    assert [hand for one in early for hand in tracker.observe(one)] == []
    assert tracker.complaint is not None, "someone who waits is told why"
    assert [hand for one in captures[:5] for hand in tracker.observe(one)] == []
    assert tracker.state == "calibrating"
    hands = follow(tracker, captures[5:])
    assert [h.markers.t_ns for h in hands] == [one.t_capture_ns for one in (*early, *captures)]
    assert all((hand.markers.status == Status.LOST).all() for hand in hands[:12])
    assert (hands[12].markers.status == Status.MEASURED).mean() > 0.8
    assert np.isfinite(hands[12].pose.joints_rad).any(), "what was held back comes back whole"


def test_a_recording_that_ends_early_comes_back_all_the_same(make: Make) -> None:
    sequence = sequence_of("easy")
    for labelled in (True, False):
        captures = received(sequence)[:7]
        tracker = make(sequence, labelled=labelled)
        hands = follow(tracker, captures)
        assert [hand.markers.t_ns for hand in hands] == [one.t_capture_ns for one in captures]
        assert tracker.finish() == (), "nothing comes twice"
        for hand, one in zip(hands, captures, strict=True):
            check(hand, one, 25)


def test_empty_captures_are_no_measurement_and_the_hand_is_found_behind_them(make: Make) -> None:
    sequence = sequence_of("easy", 2)
    captures = received(sequence)
    for index in range(30, 33):
        captures[index] = blank(captures[index].t_capture_ns, captures[index])
    hands = follow(make(sequence), captures)
    for index in range(30, 33):
        check(hands[index], captures[index], 25)
        assert (hands[index].markers.status != Status.MEASURED).all()
        assert (hands[index].pose.joint_status != Status.MEASURED).all()
    behind = [hands[index] for index in range(33, 40)]
    assert right_names(behind, sequence) > 0.95
    assert (behind[-1].markers.status == Status.MEASURED).mean() > 0.8


def test_a_hand_that_stays_away_is_lost_and_found_again(make: Make) -> None:
    sequence = sequence_of("easy", 2, 40)
    still = sequence.detections[25]
    captures = [replace(still, t_capture_ns=k * 33_333_333) for k in range(100)]
    for index in range(40, 75):
        captures[index] = blank(captures[index].t_capture_ns, still)
    tracker = make(sequence)
    hands = [hand for one in captures[:75] for hand in tracker.observe(one)]
    assert tracker.state == "lost"
    assert tracker.expected_m is None
    assert hands[-1].state == "lost"
    assert (hands[-1].markers.status == Status.LOST).all()
    assert np.isnan(hands[-1].markers.p_camera_m).all()
    assert np.isnan(hands[-1].pose.joints_rad).all()
    hands += [hand for one in captures[75:] for hand in tracker.observe(one)]
    assert tracker.state == "tracking"
    found = hands[-1].detection
    given = found >= 0
    assert given.mean() > 0.9
    owner = sequence.owner[25][found[given]]
    assert (owner == np.flatnonzero(given)).mean() > 0.9


def test_no_hand_at_all_is_nothing_understood(make: Make) -> None:
    sequence = sequence_of("easy")
    captures = [blank(k * 33_333_333, sequence.detections[0]) for k in range(40)]
    for labelled in (True, False):
        tracker = make(sequence, labelled=labelled)
        hands = follow(tracker, captures)
        assert [hand.markers.t_ns for hand in hands] == [one.t_capture_ns for one in captures]
        assert tracker.state in ("searching", "lost")
        assert tracker.complaint is not None
        for hand, one in zip(hands, captures, strict=True):
            check(hand, one, 25)
            assert (hand.markers.status != Status.MEASURED).all()
        assert np.isnan(hands[-1].pose.joints_rad).all()


def test_the_memory_of_a_long_wait_is_bounded(make: Make) -> None:
    sequence = sequence_of("easy")
    captures = [blank(k * 33_333_333, sequence.detections[0]) for k in range(900)]
    assert len(follow(make(sequence, labelled=False), captures)) <= 500


def test_a_gap_in_time_does_not_cost_the_names_of_a_still_hand(make: Make) -> None:
    sequence = sequence_of("easy", 3, 30)
    captures = received(sequence)
    later = [replace(one, t_capture_ns=one.t_capture_ns + 700_000_000) for one in captures[22:]]
    hands = follow(make(sequence), [*captures[:22], *later])
    assert len(hands) == 30
    named = [
        replace(h, markers=replace(h.markers, t_ns=captures[k].t_capture_ns)) for k, h in enumerate(hands)
    ]
    assert right_names(named, sequence) > 0.97
    assert (hands[-1].markers.status == Status.MEASURED).mean() > 0.8


def test_without_depth_the_image_is_still_followed(make: Make) -> None:
    sequence = sequence_of("easy", 2)
    captures = [without_depth(one) for one in received(sequence)]
    tracker = make(sequence)
    hands = follow(tracker, captures)
    assert [hand.markers.t_ns for hand in hands] == [one.t_capture_ns for one in captures]
    assert right_names(hands, sequence) > 0.97
    for hand, one in zip(hands, captures, strict=True):
        check(hand, one, 25)
    assert (hands[-1].markers.status == Status.MEASURED).mean() > 0.8
    said = bool(np.isfinite(hands[-1].pose.joints_rad).any())
    assert said or tracker.complaint is not None, "who gets no pose is told why"


def test_a_third_of_the_depths_missing_costs_no_names(make: Make) -> None:
    sequence = sequence_of("easy", 2)
    rng = np.random.default_rng(0)
    captures = [without_depth(one, np.flatnonzero(rng.random(len(one)) < 0.33)) for one in received(sequence)]
    hands = follow(make(sequence), captures)
    assert right_names(hands, sequence) > 0.97
    for hand, one in zip(hands, captures, strict=True):
        check(hand, one, 25)
    error = np.linalg.norm(hands[-1].markers.p_camera_m - sequence.p_camera_m[-1], axis=1)
    assert np.nanmedian(error) < 0.005


@pytest.mark.parametrize("labelled", [True, False], ids=["labels", "open-hand"])
def test_every_blob_twice_is_given_once(make: Make, labelled: bool) -> None:
    sequence = sequence_of("easy", 2)
    captures = [joined([one, one]) for one in received(sequence)]
    hands = follow(make(sequence, labelled=labelled), captures)
    assert len(hands) == len(captures)
    for hand, one in zip(hands, captures, strict=True):
        check(hand, one, 25)


def test_one_blob_or_very_many_break_nothing(make: Make) -> None:
    sequence = sequence_of("easy", 2)
    rng = np.random.default_rng(0)
    captures = received(sequence)
    everywhere = joined([captures[30].rows(rng.integers(0, len(captures[30]), 40)) for _ in range(5)])
    shift = rng.uniform(-100.0, 100.0, (200, 2))
    captures[30] = replace(everywhere, pixel_px=everywhere.pixel_px + shift)
    captures[31] = captures[31].rows(np.array([0]))
    captures[32] = captures[32].rows(np.array([0, 1]))
    hands = follow(make(sequence), captures)
    for hand, one in zip(hands, captures, strict=True):
        check(hand, one, 25)
