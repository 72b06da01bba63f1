"""Detections against the truth of the virtual camera."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from rehab_app.cameras import CLEAN, NoiseLevel, VirtualCamera, hand_scene, scripted_motion, wear_markers
from rehab_app.geometry.detections import Detections
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.protocol import load_protocol
from rehab_app.vision import MarkerDetector
from rehab_app.vision.contrast import chroma
from robot_iface.kinematics import average_hand
from sessions.records import Side
from sessions.records.fields import Float64

DETECTOR = MarkerDetector()


@dataclass
class Score:
    visible: int = 0
    found: int = 0
    false: int = 0


def camera(
    motion: str = "open_close", seed: int = 0, noise: NoiseLevel | None = None, side: Side = "right"
) -> VirtualCamera:
    geometry, rng = average_hand(0.175 + 0.0125 * seed, side), np.random.default_rng(seed)
    worn = wear_markers(geometry, load_protocol("thesis25"), rng)
    return VirtualCamera(hand_scene(worn, scripted_motion(motion), rng), seed=seed, noise=noise)


def detect(source: VirtualCamera, index: int, around: Float64 | None = None) -> Detections:
    frame = source.frame(index)
    return DETECTOR.detect(frame.t_capture_ns, frame.colour_bgr, frame.depth_m, frame.intrinsics, around)


def errors(source: VirtualCamera, index: int, score: Score) -> tuple[Float64, Float64, Float64]:
    """Pixel errors, point errors and normalised squared errors of well visible markers in one frame."""
    truth, seen = source.truth(index / 30), detect(source, index)
    apart = np.linalg.norm(truth.pixel_px[:, None] - seen.pixel_px, axis=2)
    rows, columns = linear_sum_assignment(apart)
    near = apart[rows, columns] < 4
    rows, columns = rows[near], columns[near]
    good = (truth.seen > 0.8) & (truth.markers.facing() > 0.3)
    score.visible += int(good.sum())
    score.found += int(good[rows].sum())
    score.false += len(seen) - len(rows)
    rows, columns = rows[good[rows]], columns[good[rows]]
    point = seen.p_camera_m[columns] - truth.markers.p_camera_m[rows]
    weight = np.linalg.inv(seen.covariance_m2[columns])
    pixel = seen.pixel_px[columns] - truth.pixel_px[rows]
    return pixel, point, np.einsum("ni,nij,nj->n", point, weight, point)


def test_clean_centres_are_the_projected_markers() -> None:
    pixel, point, _ = errors(camera(noise=CLEAN), 10, Score())
    assert len(pixel) >= 24
    assert np.abs(pixel).max() < 0.3
    assert np.abs(point).max() < 0.001


@pytest.mark.parametrize(("motion", "side"), [("open_close", "right"), ("pinch", "left")])
def test_recall_precision_and_lift(motion: str, side: Side) -> None:
    score, parts = Score(), []
    for seed in range(3):
        parts += [errors(camera(motion, seed, side=side), index, score) for index in range(0, 150, 18)]
    pixel, point, square = (np.concatenate(part) for part in zip(*parts, strict=True))
    assert score.found / score.visible > 0.99
    assert score.found / (score.found + score.false) > 0.99
    assert np.sqrt((pixel**2).mean(axis=0)).max() < 0.15
    assert np.sqrt((point**2).mean(axis=0)).max() < 0.001
    assert 0.5 < square.mean() < 3.5  # three degrees of freedom; a little modest by intent


def test_a_window_finds_the_same_markers() -> None:
    source = camera()
    whole, part = detect(source, 20), detect(source, 20, source.truth(20 / 30).markers.p_camera_m)
    assert len(whole) == len(part) == 25
    assert part.pixel_px == pytest.approx(whole.pixel_px, abs=0.02)


def test_blue_without_a_ring_or_far_behind_is_no_marker() -> None:
    source = camera()
    frame = source.frame(0)
    assert 0.5 < frame.depth_m[360, 310] < 0.9
    cv2.circle(frame.colour_bgr, (310, 360), 5, (196, 92, 34), -1)  # on the forearm, no ring
    cv2.circle(frame.colour_bgr, (540, 100), 7, (238, 238, 238), -1)  # a marker on the wall
    cv2.circle(frame.colour_bgr, (540, 100), 5, (196, 92, 34), -1)
    seen = DETECTOR.detect(0, frame.colour_bgr, frame.depth_m, frame.intrinsics)
    assert len(seen) == 25


def test_an_empty_picture_holds_nothing() -> None:
    colour, depth = np.full((480, 640, 3), 128, np.uint8), np.zeros((480, 640), np.float32)
    seen = DETECTOR.detect(5, colour, depth, KINECT)
    assert len(seen) == 0
    assert seen.p_camera_m.shape == (0, 3)
    assert seen.covariance_m2.shape == (0, 3, 3)


@pytest.mark.parametrize("gain", [0.6, 1.25])
def test_the_light_may_change(gain: float) -> None:
    frame = camera().frame(0)
    lit = np.clip(frame.colour_bgr * gain, 0, 255).astype(np.uint8)
    assert len(DETECTOR.detect(0, lit, frame.depth_m, frame.intrinsics)) >= 24


def test_chroma_is_the_stated_formula() -> None:
    pixel = np.array([[[196, 92, 34], [238, 238, 238]]], np.uint8)
    assert chroma(pixel) == pytest.approx(np.array([[162 / 382, 0.0]]), abs=1e-6)
