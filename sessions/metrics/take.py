"""Measures a take: a recorded demonstration without anybody to be compared with."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.metrics.hand_motion import (
    HandMotion,
    active_motion_metrics,
    main_cycles,
    range_metrics,
    stroke_metrics,
)
from sessions.metrics.honest import honest
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.opening_numbers import opening_metrics, rhythm_metrics
from sessions.metrics.overlay import thin
from sessions.metrics.recording import Origin, Recording, seconds
from sessions.metrics.repetitions import Cycles
from sessions.metrics.summary import Overlay, Summary
from sessions.metrics.visibility import fit_residual, longest_gap, valid_share
from sessions.records import Status
from sessions.records.fields import Float64
from sessions.records.topics import HAND_POSE, MARKERS


def measure_take(recording: Recording) -> Summary:
    """All numbers of a take.

    Raises:
        Refused: The file holds no hand pose.
    """
    header = recording.header
    if recording.counts.get(HAND_POSE.name, 0) < 2:
        raise Refused(
            f"take {header.session_id[:8]}",
            "without hand poses",
            f"a recording with {HAND_POSE.name}",
            "fit the hand first, with rehab-app track or rehab-app import",
        )
    rows = recording.columns(HAND_POSE)
    motion, residual = hand_motion(rows), np.asarray(rows["residual_m"], dtype=np.float64)
    origin = Origin(recording.sha256, header.source)
    cycles = main_cycles(motion)
    numbers = [
        *range_metrics(motion, origin),
        *repetition_metrics(motion, cycles, origin),
        *stroke_metrics(motion, cycles.strokes_s, origin),
        *active_motion_metrics(motion, origin),
        *opening_metrics(motion, header.subject_hand, origin),
        *rhythm_metrics(motion, cycles, origin),
        metric("fit_residual", "whole", fit_residual(residual), origin.lineage((HAND_POSE,), motion.t_ns)),
        *_marker_metrics(recording, origin),
    ]
    t_s = seconds(motion.t_ns)
    shown = Overlay("the whole take", thin(t_s, motion.joints_rad, motion.usable_tips()), None)
    return Summary(header, recording.sha256, float(t_s[-1]), (), "", tuple(honest(numbers)), (), (), shown)


def repetition_metrics(motion: HandMotion, found: Cycles, origin: Origin) -> list[Metric]:
    """How often and how fast the main movement was repeated."""
    lineage = origin.lineage((motion.topic,), motion.t_ns)
    rate = (
        Estimate(found.rate_hz, _rate_interval(found, motion))
        if math.isfinite(found.rate_hz)
        else Estimate.missing("fewer than two repetitions")
    )
    if math.isnan(found.amplitude_rad):
        count = Estimate.missing("the main movement was never seen for 0.3 s without a gap")
    else:
        count = Estimate(float(found.count))
    return [
        metric("repetitions", "whole", count, lineage),
        metric("repetition_rate", "whole", rate, lineage),
    ]


def _rate_interval(found: Cycles, motion: HandMotion) -> tuple[float, float]:
    """Each turning point is known to one frame."""
    frame_s = float(np.median(np.diff(motion.t_ns))) * 1e-9
    turns_s = max(found.count - 1, 1) / found.rate_hz
    relative = 2.0 * frame_s / turns_s
    return (max(0.0, found.rate_hz * (1.0 - relative)), found.rate_hz * (1.0 + relative))


def hand_motion(rows: Any) -> HandMotion:
    """The hand of the rows of /hand/pose."""
    joint_variance = np.diagonal(
        np.asarray(rows["joint_covariance_rad2"], dtype=np.float64), axis1=1, axis2=2
    )
    tip_covariance = np.asarray(rows["fingertip_covariance_m2"], dtype=np.float64)
    return HandMotion(
        HAND_POSE,
        np.asarray(rows["t_ns"], dtype=np.int64),
        np.asarray(rows["joints_rad"], dtype=np.float64),
        _root(joint_variance),
        np.asarray(rows["joint_status"], dtype=np.uint8),
        np.asarray(rows["fingertips_palm_m"], dtype=np.float64),
        _root(np.trace(tip_covariance, axis1=2, axis2=3) / 3.0),
    )


def _root(variance: Float64) -> Float64:
    """Standard deviation, NaN where the variance is unknown (NaN or negative)."""
    return np.sqrt(np.where(variance >= 0.0, variance, np.nan))


def _marker_metrics(recording: Recording, origin: Origin) -> list[Metric]:
    names = recording.header.marker_names
    if not names or not recording.counts.get(MARKERS.name, 0):
        return []
    rows = recording.columns(MARKERS)
    t_ns: NDArray[np.int64] = np.asarray(rows["t_ns"], dtype=np.int64)
    measured = (np.asarray(rows["status"]) == Status.MEASURED).reshape(len(t_ns), -1)
    lineage, t_s = origin.lineage((MARKERS,), t_ns), seconds(t_ns)
    found: list[Metric] = []
    for column, name in enumerate(names):
        found.append(metric("valid_share", name, valid_share(measured[:, column]), lineage))
        found.append(metric("longest_gap", name, longest_gap(t_s, measured[:, column]), lineage))
    return found
