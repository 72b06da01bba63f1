"""What the contract of trackers is checked with."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.geometry.detections import Detections
from rehab_app.geometry.view import View
from rehab_app.tracking import Labels, TrackedHand, Tracker, make_tracker
from sessions.records import Status
from sessions.records.fields import Int64

STATES = {"searching", "calibrating", "tracking", "lost"}
BESIDE = View(1, np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]), np.array([-0.7, 0.0, 0.7]))
Make = Callable[..., Tracker]


def maker(name: str) -> Make:
    """Makes a tracker for a sequence, with the labels of its first frame unless told otherwise."""

    def made(sequence: PointSequence, *, labelled: bool = True, seed: int = 0) -> Tracker:
        labels = Labels(sequence.protocol.names, sequence.init_pixel_px) if labelled else None
        return make_tracker(name, sequence.protocol, sequence.side, labels=labels, seed=seed)

    return made


@cache
def sequence_of(level: str, seed: int = 1, frames: int = 45) -> PointSequence:
    return point_sequence(level, seed, frames)


def received(sequence: PointSequence) -> list[Detections]:
    return [one for _, one in sequence.received()]


def follow(tracker: Tracker, captures: Iterable[Detections]) -> list[TrackedHand]:
    hands = [hand for one in captures for hand in tracker.observe(one)]
    return [*hands, *tracker.finish()]


def blank(t_ns: int, like: Detections) -> Detections:
    return replace(like.rows(np.empty(0, dtype=np.int64)), t_capture_ns=t_ns)


def without_depth(one: Detections, which: Int64 | None = None) -> Detections:
    points, covariance = one.p_camera_m.copy(), one.covariance_m2.copy()
    rows = np.arange(len(one)) if which is None else which
    points[rows], covariance[rows] = np.nan, np.nan
    return replace(one, p_camera_m=points, covariance_m2=covariance)


def check(hand: TrackedHand, seen: Detections, markers: int) -> None:
    """Shapes, statuses and gaps of one capture."""
    frame, pose = hand.markers, hand.pose
    assert hand.state in STATES
    assert frame.t_ns == pose.t_ns == seen.t_capture_ns
    assert frame.p_camera_m.shape == (markers, 3)
    assert frame.covariance_m2.shape == (markers, 3, 3)
    assert frame.status.shape == frame.similarity.shape == hand.detection.shape == (markers,)
    assert frame.pixel_px.shape == (markers, 2)
    assert set(frame.status.tolist()) <= {Status.LOST, Status.ESTIMATED, Status.MEASURED}

    given = hand.detection >= 0
    rows = hand.detection[given]
    assert len(np.unique(rows)) == len(rows), "a detection is given once"
    assert (rows < len(seen)).all()
    assert np.array_equal(frame.status == Status.MEASURED, given)
    assert np.array_equal(frame.pixel_px[given], seen.pixel_px[rows])
    assert np.array_equal(frame.similarity[given], seen.similarity[rows])
    assert (frame.similarity[~given] == 0.0).all()

    placed = np.isfinite(frame.p_camera_m).all(axis=1)
    assert np.array_equal(placed, np.isfinite(frame.p_camera_m).any(axis=1)), "a gap is a whole one"
    assert np.array_equal(placed, np.isfinite(frame.covariance_m2).all(axis=(1, 2)))
    lost = frame.status == Status.LOST
    assert not placed[lost].any()
    assert np.isnan(frame.pixel_px[lost]).all()
    spread = frame.covariance_m2[placed]
    assert spread == pytest.approx(np.swapaxes(spread, 1, 2), abs=1e-12)
    assert (np.linalg.eigvalsh(spread) > 0).all()
    check_pose(hand)


def check_pose(hand: TrackedHand) -> None:
    pose = hand.pose
    assert pose.joints_rad.shape == pose.joint_status.shape == (21,)
    assert pose.joint_covariance_rad2.shape == (21, 21)
    assert pose.fingertips_palm_m.shape == (5, 3)
    assert pose.fingertip_covariance_m2.shape == (5, 3, 3)
    known = np.isfinite(pose.joints_rad)
    assert np.array_equal(known, pose.joint_status != Status.LOST)
    assert np.array_equal(np.isfinite(np.diagonal(pose.joint_covariance_rad2)), known)
    assert np.isfinite(pose.q_camera_palm_wxyz).all() == np.isfinite(pose.p_camera_palm_m).all()
    if np.isfinite(pose.q_camera_palm_wxyz).all():
        assert np.linalg.norm(pose.q_camera_palm_wxyz) == pytest.approx(1.0)
    else:
        assert not known.any(), "no joints without a palm"


def right_names(hands: list[TrackedHand], sequence: PointSequence) -> float:
    """Share of the given detections that are the marker's own (or a blob merged of it)."""
    index = {int(t_ns): frame for frame, t_ns in enumerate(sequence.t_ns)}
    good = total = 0
    for hand in hands:
        frame = index[hand.markers.t_ns]
        marker = np.flatnonzero(hand.detection >= 0)
        row = hand.detection[marker]
        good += int(((sequence.owner[frame][row] == marker) | (sequence.other[frame][row] == marker)).sum())
        total += len(marker)
    return good / max(total, 1)
