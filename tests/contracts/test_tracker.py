"""What every tracker must do; run over each of them, made by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.geometry.view import PRIMARY
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.tracking import TRACKERS, Labels, Tracker, make_tracker
from sessions.errors import Refused
from sessions.records import Status
from sessions.records.fields import Int64
from tests.contracts.tracker_checks import (
    BESIDE,
    Make,
    check,
    follow,
    maker,
    received,
    right_names,
    sequence_of,
)


@pytest.fixture(params=TRACKERS)
def make(request: pytest.FixtureRequest) -> Make:
    """Makes a tracker for a sequence; see ``maker``."""
    return maker(request.param)


@pytest.mark.parametrize("level", ["easy", "hard"])
@pytest.mark.parametrize("labelled", [True, False], ids=["labels", "open-hand"])
def test_every_capture_comes_back_once_in_order_and_well_formed(
    make: Make, level: str, labelled: bool
) -> None:
    sequence = sequence_of(level)
    tracker, captures = make(sequence, labelled=labelled), received(sequence)
    assert tracker.marker_names == sequence.protocol.names
    hands = follow(tracker, captures)
    assert [hand.markers.t_ns for hand in hands] == [one.t_capture_ns for one in captures]
    for hand, one in zip(hands, captures, strict=True):
        check(hand, one, len(sequence.protocol.names))


@pytest.mark.parametrize("labelled", [True, False], ids=["labels", "open-hand"])
def test_an_easy_hand_is_named_rightly_and_the_person_learnt(make: Make, labelled: bool) -> None:
    sequence = sequence_of("easy", 2)
    tracker = make(sequence, labelled=labelled)
    hands = follow(tracker, received(sequence))
    assert right_names(hands, sequence) > 0.98
    assert tracker.state == "tracking"
    assert tracker.complaint is None
    assert tracker.subject is not None
    assert tracker.subject.geometry.side == sequence.side
    last = hands[-1]
    assert (last.markers.status == Status.MEASURED).mean() > 0.8
    assert np.isfinite(last.pose.joints_rad).all()
    error = np.linalg.norm(last.markers.p_camera_m - sequence.p_camera_m[-1], axis=1)
    assert np.nanmedian(error) < 0.004


def test_what_is_expected_lies_where_the_hand_is(make: Make) -> None:
    sequence = sequence_of("easy", 2)
    tracker = make(sequence)
    follow(tracker, received(sequence))
    expected = tracker.expected_m
    assert expected is not None
    assert expected.shape[1] == 3
    assert np.isfinite(expected).all()
    apart = np.linalg.norm(expected[:, None] - sequence.p_camera_m[-1], axis=2).min(axis=1)
    assert np.median(apart) < 0.01


def test_the_same_seed_gives_the_same_bits(make: Make) -> None:
    sequence = sequence_of("hard")
    here, there = (follow(make(sequence, seed=5), received(sequence)) for _ in range(2))
    for one, other in zip(here, there, strict=True):
        assert np.array_equal(one.detection, other.detection)
        assert np.array_equal(one.markers.p_camera_m, other.markers.p_camera_m, equal_nan=True)
        assert np.array_equal(one.pose.joints_rad, other.pose.joints_rad, equal_nan=True)


def test_a_second_camera_is_welcome_whichever_comes_first(make: Make) -> None:
    sequence = backwards(point_sequence("easy", 4, 40, views=(PRIMARY, BESIDE)))
    assert any((one.view == 1).any() for one in sequence.detections)
    hands = follow(make(sequence), received(sequence))
    assert right_names(hands, sequence) > 0.97
    for hand, one in zip(hands, received(sequence), strict=True):
        check(hand, one, 25)


def one_finger_and_thumb() -> MarkerProtocol:
    """The eight markers of index and thumb, as a clinic's own protocol would have them."""
    whole = load_protocol("thesis25")
    kept = tuple(replace(one, links=()) for one in whole.markers if one.name.startswith(("thumb", "index")))
    return replace(whole, name="pinch8", markers=kept)


@pytest.mark.parametrize("protocol", [load_protocol("fingertips5"), one_finger_and_thumb()], ids=["5", "8"])
def test_other_protocols_are_followed_too(make: Make, protocol: MarkerProtocol) -> None:
    sequence = point_sequence("easy", 5, 40, protocol)
    hands = follow(make(sequence), received(sequence))
    assert right_names(hands, sequence) > 0.95
    for hand, one in zip(hands, received(sequence), strict=True):
        check(hand, one, len(protocol.names))


def test_labels_of_some_markers_are_enough_to_begin(make: Make) -> None:
    sequence = sequence_of("easy", 2)
    kept = np.arange(0, 25, 2)
    names = tuple(sequence.protocol.names[k] for k in kept)
    hands = follow(make_partial(make, sequence, names, kept), received(sequence))
    named = [
        replace(hand, detection=np.where(np.isin(np.arange(25), kept), hand.detection, -1)) for hand in hands
    ]
    assert right_names(named, sequence) > 0.97
    assert (hands[0].markers.status[kept] == Status.MEASURED).mean() > 0.8


@pytest.mark.parametrize("name", TRACKERS)
@pytest.mark.parametrize(
    ("names", "part"),
    [
        (("nose", "index_tip", "middle_tip", "ring_tip"), "nose"),
        (("index_tip", "index_tip", "middle_tip", "ring_tip"), "twice"),
    ],
)
def test_labels_that_name_no_marker_or_one_twice_are_refused(
    name: str, names: tuple[str, ...], part: str
) -> None:
    sequence = sequence_of("easy")
    labels = Labels(names, sequence.init_pixel_px[: len(names)])
    with pytest.raises(Refused, match=part):
        make_tracker(name, sequence.protocol, sequence.side, labels=labels)


def test_an_unknown_tracker_is_refused_by_name() -> None:
    sequence = sequence_of("easy")
    with pytest.raises(Refused, match="'hungarian', but must be one of kinematic, rbmcda"):
        make_tracker("hungarian", sequence.protocol, sequence.side)


def backwards(sequence: PointSequence) -> PointSequence:
    """The same with the detections of every capture in reverse order."""
    return replace(
        sequence,
        detections=tuple(one.rows(np.arange(len(one))[::-1]) for one in sequence.detections),
        owner=tuple(owner[::-1] for owner in sequence.owner),
        other=tuple(other[::-1] for other in sequence.other),
    )


def make_partial(make: Make, sequence: PointSequence, names: tuple[str, ...], rows: Int64) -> Tracker:
    """A tracker that was told only some names: as ``make``, with the other clicks left out (NaN)."""
    pixel = np.full_like(sequence.init_pixel_px, np.nan)
    pixel[rows] = sequence.init_pixel_px[rows]
    assert len(names) == len(rows)
    return make(replace(sequence, init_pixel_px=pixel))
