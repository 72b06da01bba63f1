"""Identity on point sequences with truth: labels, loss, other sides, rates and sensors."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.geometry.detections import Detections
from rehab_app.tracking import KinematicTracker, Labels, TrackedHand
from sessions.errors import Refused
from sessions.records import Side, Status


@cache
def sequence_of(
    level: str, seed: int, side: Side = "right", frames: int = 150, rate_hz: float = 30.0
) -> PointSequence:
    return point_sequence(level, seed, frames, side=side, rate_hz=rate_hz)


def labels_of(sequence: PointSequence, every: int = 1) -> Labels:
    return Labels(sequence.protocol.names[::every], sequence.init_pixel_px[::every])


def tracked(sequence: PointSequence, labels: Labels | None = None) -> list[TrackedHand]:
    tracker = KinematicTracker(sequence.protocol, sequence.side, labels=labels or labels_of(sequence))
    return [hand for _, one in sequence.received() for hand in tracker.observe(one)]


def right_share(sequence: PointSequence, hands: list[TrackedHand]) -> float:
    """Share of the detections of markers that got their own name."""
    index = {int(t_ns): frame for frame, t_ns in enumerate(sequence.t_ns)}
    right = total = 0
    for hand in hands:
        owner = sequence.owner[index[hand.markers.t_ns]]
        given = np.flatnonzero(hand.detection >= 0)
        right += int((owner[hand.detection[given]] == given).sum())
        total += int((owner >= 0).sum())
    return right / total


@pytest.mark.parametrize(
    ("level", "seed", "side", "least"),
    [("easy", 61, "left", 0.99), ("medium", 62, "right", 0.98), ("hard", 63, "left", 0.95)],
)
def test_markers_keep_their_names(level: str, seed: int, side: Side, least: float) -> None:
    sequence = sequence_of(level, seed, side)
    hands = tracked(sequence)
    assert len(hands) == int((~sequence.dropped).sum())  # with labels nothing is held back
    assert right_share(sequence, hands) > least


@pytest.mark.parametrize("rate_hz", [15.0, 60.0])
def test_other_frame_rates_do_as_well(rate_hz: float) -> None:
    sequence = sequence_of("medium", 64, frames=round(4 * rate_hz), rate_hz=rate_hz)
    assert right_share(sequence, tracked(sequence)) > 0.97


def test_half_of_the_labels_are_enough() -> None:
    sequence = sequence_of("medium", 62)
    assert right_share(sequence, tracked(sequence, labels_of(sequence, 2))) > 0.97


def without_depth(detections: Detections) -> Detections:
    nothing = np.full_like(detections.p_camera_m, np.nan)
    return replace(
        detections, p_camera_m=nothing, covariance_m2=np.full_like(detections.covariance_m2, np.nan)
    )


def test_without_depth_it_goes_on_in_two_dimensions() -> None:
    sequence = sequence_of("easy", 65)
    flat = replace(sequence, detections=tuple(without_depth(one) for one in sequence.detections))
    hands = tracked(flat)
    assert right_share(flat, hands) > 0.97
    spread = np.mean(
        [np.diagonal(hand.markers.covariance_m2, axis1=1, axis2=2) for hand in hands[5:]], axis=0
    )
    assert (spread[:, 2] > 4.0 * spread[:, 0]).mean() > 0.9


def test_a_hand_that_leaves_and_returns_in_motion_gets_its_names_back() -> None:
    sequence = sequence_of("medium", 66, frames=180)
    gone = [
        one.rows(np.empty(0, dtype=np.int64)) if 70 <= frame < 100 else one
        for frame, one in enumerate(sequence.detections)
    ]
    hands = tracked(replace(sequence, detections=tuple(gone)))
    by_time = {hand.markers.t_ns: hand for hand in hands}
    middle = by_time[int(sequence.t_ns[90])]
    assert middle.state == "lost"
    assert (middle.markers.status == Status.LOST).all()
    late = [hand for hand in hands if hand.markers.t_ns > sequence.t_ns[110]]
    assert right_share(sequence, late) > 0.95


def test_joint_intervals_hold_what_they_promise() -> None:
    inside = []
    for seed in (67, 68):
        sequence = sequence_of("medium", seed)
        index = {int(t_ns): frame for frame, t_ns in enumerate(sequence.t_ns)}
        for hand in tracked(sequence)[30:]:
            off = hand.pose.joints_rad - sequence.joints_rad[index[hand.markers.t_ns]]
            std = np.sqrt(np.diagonal(hand.pose.joint_covariance_rad2))
            inside.append((np.abs(off) < 1.96 * std)[np.isfinite(off)])
    assert np.concatenate(inside).mean() > 0.9


def test_the_same_captures_give_the_same_tracks() -> None:
    sequence = sequence_of("hard", 63, "left")
    one, other = tracked(sequence), tracked(sequence)
    np.testing.assert_array_equal(one[-1].pose.joints_rad, other[-1].pose.joints_rad)


def test_labels_that_mean_nothing_are_refused() -> None:
    sequence = sequence_of("easy", 65)
    pixel = sequence.init_pixel_px[:4]
    for names, match in (
        (("index_tip", "nose", "wrist", "cmc4"), "nose"),
        (("index_tip", "index_tip", "wrist", "cmc4"), "twice"),
    ):
        with pytest.raises(Refused, match=match):
            KinematicTracker(sequence.protocol, "right", labels=Labels(names, pixel))
    with pytest.raises(Refused, match="4 or more"):
        KinematicTracker(sequence.protocol, "right", labels=Labels(("wrist",), pixel[:1]))


def test_what_keeps_it_from_working_is_said_in_a_sentence() -> None:
    sequence = sequence_of("easy", 65)
    tracker = KinematicTracker(sequence.protocol, "left")
    for one in sequence.detections[:10]:
        tracker.observe(one)
    assert tracker.complaint is not None
    assert "right hand" in tracker.complaint
    empty = KinematicTracker(sequence.protocol, "right")
    for one in sequence.detections[:10]:
        empty.observe(one.rows(np.arange(3)))
    assert empty.complaint is not None
    assert "3 of the 25" in empty.complaint
    names = sequence.protocol.names
    hidden = [names.index("index_tip"), names.index("wrist"), names.index("cmc4"), names.index("ring_dip")]
    partial = KinematicTracker(sequence.protocol, "right")
    for frame, one in enumerate(sequence.detections[:10]):
        partial.observe(one.rows(np.flatnonzero(~np.isin(sequence.owner[frame], hidden))))
    assert partial.complaint is not None
    assert "index_tip" in partial.complaint
