"""Runs a tracker of the product over a point sequence and collects what it says."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from rehab_app.cameras.sequence import PointSequence
from rehab_app.tracking import Labels, TrackedHand, make_tracker
from sessions.records.fields import Float64
from tests.bench.tracking.score import Tracks


@dataclass(frozen=True)
class Run:
    """Tracks of one sequence and what they cost.

    Attributes:
        tracks: What was said.
        ms: Mean time of a frame, ms; learning the hand included.
        joints_rad: Joint angles, NaN where nothing was said, shape (F, 21).
    """

    tracks: Tracks
    ms: float
    joints_rad: Float64


def run_tracker(name: str, sequence: PointSequence, seed: int = 0) -> Run:
    """Run one of the product's trackers with the labels of frame 0."""
    labels = Labels(sequence.protocol.names, sequence.init_pixel_px)
    tracker = make_tracker(name, sequence.protocol, sequence.side, labels=labels, seed=seed)
    frames, markers = sequence.visible.shape
    pixel = np.full((frames, markers, 2), np.nan)
    detection = np.full((frames, markers), -1, dtype=np.int64)
    joints = np.full((frames, 21), np.nan)
    index = {int(t_ns): frame for frame, t_ns in enumerate(sequence.t_ns)}
    start = time.perf_counter()
    hands = [hand for _, one in sequence.received() for hand in tracker.observe(one)]
    ms = 1e3 * (time.perf_counter() - start) / frames
    for hand in hands:
        row = index[hand.markers.t_ns]
        pixel[row] = _pixels(hand, sequence)
        detection[row] = hand.detection
        joints[row] = hand.pose.joints_rad
    return Run(Tracks(pixel, detection), ms, joints)


def _pixels(hand: TrackedHand, sequence: PointSequence) -> Float64:
    """Where the markers are said to be in the image: the projected point, else the blob itself, (M, 2)."""
    points = np.where(hand.markers.p_camera_m[:, 2:] > 0.05, hand.markers.p_camera_m, np.nan)
    placed = sequence.intrinsics.project(points)
    return np.where(np.isfinite(placed), placed, hand.markers.pixel_px)
