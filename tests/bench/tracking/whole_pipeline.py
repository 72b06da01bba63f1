"""From picture to hand at a level: frames per second on one core, and how far the fingertips are off.

Times are those of the processor, so that other load on the machine counts little.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras import Truth, virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.tracking import TrackedHand, make_tracker
from rehab_app.vision import make_detector
from sessions.records import Status
from sessions.records.fields import Float64

TIPS = ("thumb_tip", "index_tip", "middle_tip", "ring_tip", "little_tip")


@dataclass(frozen=True)
class PipelineFigures:
    """What was measured; errors in mm of the fingertips' markers against the truth."""

    fps: float
    median_fps: float
    detect_ms: float
    track_ms: float
    seen_median_mm: float
    seen_rms_mm: float
    all_median_mm: float
    all_rms_mm: float
    wrong_share: float
    """Of the measured labels: those farther than 8 px from their marker."""


@dataclass(frozen=True)
class Compared:
    """One capture beside the truth.

    Attributes:
        error_m: Distance of each fingertip's marker from the truth, shape (5,).
        measured: Whether each was measured, shape (5,).
        beside_px: How far each measured label is from its marker in the image, shape (K,).
    """

    error_m: Float64
    measured: NDArray[np.bool_]
    beside_px: Float64


def run_pipeline(level: str, seed: int, seconds: float) -> PipelineFigures:
    """Detect and track a rendered mixed sequence; drawing is not counted."""
    cv2.setNumThreads(1)
    protocol = load_protocol("thesis25")
    camera = virtual_camera("mixed", "right", seconds, protocol, seed=seed, level=level)
    detector, tracker = make_detector("contrast"), make_tracker("kinematic", protocol, "right", seed=seed)
    hands: list[TrackedHand] = []
    spent: list[tuple[float, float]] = []
    with camera:
        for frame in camera.frames():
            if frame.t_capture_ns > seconds * 1e9:
                break
            times = [time.process_time()]
            found = detector.detect(
                frame.t_capture_ns, frame.colour_bgr, frame.depth_m, frame.intrinsics, tracker.expected_m
            )
            times.append(time.process_time())
            hands.extend(tracker.observe(found))
            times.append(time.process_time())
            spent.append((times[1] - times[0], times[2] - times[1]))
    compared = [_compared(hand, camera.truth(1e-9 * hand.markers.t_ns)) for hand in hands]
    return _figures(np.array(spent), compared)


def _compared(hand: TrackedHand, truth: Truth) -> Compared:
    """One capture beside the truth."""
    names = load_protocol("thesis25").names
    tips = [names.index(tip) for tip in TIPS]
    measured = hand.markers.status == Status.MEASURED
    error = np.linalg.norm(hand.markers.p_camera_m - truth.markers.p_camera_m, axis=1)
    beside = np.linalg.norm(hand.markers.pixel_px - truth.pixel_px, axis=1)
    return Compared(error[tips], measured[tips], beside[measured])


def _figures(spent: Float64, compared: list[Compared]) -> PipelineFigures:
    errors = 1e3 * np.array([one.error_m for one in compared])
    seen = np.array([one.measured for one in compared])
    known = np.isfinite(errors)
    beside = np.concatenate([one.beside_px for one in compared])
    frame = spent.sum(axis=1)
    return PipelineFigures(
        fps=float(1.0 / frame.mean()),
        median_fps=float(1.0 / np.median(frame)),
        detect_ms=float(1e3 * np.median(spent[:, 0])),
        track_ms=float(1e3 * np.median(spent[:, 1])),
        seen_median_mm=float(np.median(errors[seen & known])),
        seen_rms_mm=float(np.sqrt(np.mean(errors[seen & known] ** 2))),
        all_median_mm=float(np.median(errors[known])),
        all_rms_mm=float(np.sqrt(np.mean(errors[known] ** 2))),
        wrong_share=float(np.mean(beside > 8.0)),
    )
