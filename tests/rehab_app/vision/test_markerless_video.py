from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.vision.markerless import BareHandDetector, HandLandmarker, HandSighting
from sessions.errors import Refused
from sessions.records import Side
from sessions.records.fields import Float64

Image = NDArray[np.uint8]
FIRST, COUNT = 240, 45
PERIOD_NS = 33_333_333
CAMERA = Intrinsics(1100.0, 1100.0, 639.5, 359.5, 1280, 720)


@pytest.fixture(scope="module")
def pictures(shared_data: Path) -> Sequence[Image]:
    video = cv2.VideoCapture(str(shared_data / "human_hand_video" / "human_hand_video.mp4"))
    images = [video.read()[1] for _ in range(FIRST + COUNT)][FIRST:]
    video.release()
    return [np.asarray(image, dtype=np.uint8) for image in images]


@pytest.fixture(scope="module")
def published_m(shared_data: Path) -> Float64:
    with np.load(shared_data / "human_hand_video" / "landmarks_m.npz") as arrays:
        return arrays["landmarks_m"][FIRST : FIRST + COUNT].astype(np.float64)


@pytest.fixture(scope="module")
def sightings(networks: Path, pictures: Sequence[Image]) -> list[HandSighting]:
    hand = HandLandmarker("right", networks)
    seen = [hand.observe(PERIOD_NS * index, image) for index, image in enumerate(pictures)]
    assert hand.hands == 1
    return [one for one in seen if one is not None]


def aligned(p: Float64, q: Float64) -> Float64:
    """p (21, 3) after the similarity that brings it nearest to q."""
    a, b = p - p.mean(axis=0), q - q.mean(axis=0)
    u, s, vt = np.linalg.svd(b.T @ a)
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = (s * np.diag(turn)).sum() / (a**2).sum()
    return scale * a @ (u @ turn @ vt).T + q.mean(axis=0)


def test_landmarks_agree_with_the_published_ones(sightings: list[HandSighting], published_m: Float64) -> None:
    assert len(sightings) == COUNT
    error = [
        np.linalg.norm(aligned(one.world_m, truth) - truth, axis=1)
        for one, truth in zip(sightings, published_m, strict=True)
    ]
    assert np.median(error) < 0.0006
    assert np.percentile(error, 95) < 0.002


def test_the_side_is_seen_but_only_said(sightings: list[HandSighting]) -> None:
    assert {one.looks_like for one in sightings} == {"right"}


def test_landmarks_stay_within_the_hand(sightings: list[HandSighting]) -> None:
    """Pixels and places agree: a scale and a shift bring one onto the other, without a turn."""
    for one in sightings[::10]:
        flat, pixel = one.world_m[:, :2], one.pixel_px
        flat, pixel = flat - flat.mean(axis=0), pixel - pixel.mean(axis=0)
        rest = pixel - flat * (flat * pixel).sum() / (flat**2).sum()
        assert np.sqrt((rest**2).mean()) < 0.05 * np.ptp(pixel[:, 1])


@pytest.mark.parametrize("turn", [cv2.ROTATE_90_CLOCKWISE, cv2.ROTATE_180])
def test_a_turned_picture_gives_turned_landmarks(
    networks: Path, pictures: Sequence[Image], sightings: list[HandSighting], turn: int
) -> None:
    hand = HandLandmarker("right", networks)
    for index in range(3):
        image = np.ascontiguousarray(cv2.rotate(pictures[index], turn), dtype=np.uint8)
        seen = hand.observe(PERIOD_NS * index, image)
    assert seen is not None
    u, v = sightings[2].pixel_px.T
    expected = {cv2.ROTATE_90_CLOCKWISE: (719.0 - v, u), cv2.ROTATE_180: (1279.0 - u, 719.0 - v)}[turn]
    apart = np.linalg.norm(seen.pixel_px - np.stack(expected, axis=1), axis=1)
    assert np.median(apart) < 8.0
    x, y, z = sightings[2].world_m.T
    turned = {cv2.ROTATE_90_CLOCKWISE: (-y, x, z), cv2.ROTATE_180: (-x, -y, z)}[turn]
    assert np.median(np.linalg.norm(seen.world_m - np.stack(turned, axis=1), axis=1)) < 0.008


def test_a_lost_hand_is_found_again(networks: Path, pictures: Sequence[Image]) -> None:
    hand = HandLandmarker("right", networks)
    black = np.zeros_like(pictures[0])
    assert hand.observe(0, pictures[0]) is not None
    for index in (1, 2):
        assert hand.observe(PERIOD_NS * index, black) is None
    moved = np.ascontiguousarray(np.roll(pictures[3], -300, axis=1))
    assert hand.observe(PERIOD_NS * 3, moved) is not None


def test_no_hand_is_none(networks: Path) -> None:
    hand = HandLandmarker("right", networks)
    noise = np.random.default_rng(1).integers(0, 255, (480, 640, 3), dtype=np.uint8)
    for index, image in enumerate((np.zeros_like(noise), np.full_like(noise, 255), noise)):
        assert hand.observe(PERIOD_NS * index, image) is None


@pytest.mark.parametrize("side", ["left", "right"])
def test_of_two_hands_the_stated_one_is_followed(
    networks: Path, pictures: Sequence[Image], side: Side
) -> None:
    half = pictures[0][:, 300:1280]
    both = np.ascontiguousarray(np.concatenate([half, half[:, ::-1]], axis=1))
    hand = HandLandmarker(side, networks)
    seen = hand.observe(0, both)
    assert seen is not None
    assert (hand.hands, seen.looks_like) == (2, side)
    detector = BareHandDetector(side, networks)
    detector.detect(0, both, None, CAMERA)
    assert "Two hands are in view" in (detector.doubt() or "")


def test_the_other_hand_is_doubted_not_taken(networks: Path, pictures: Sequence[Image]) -> None:
    detector = BareHandDetector("right", networks)
    for index, image in enumerate(pictures[:32]):
        mirrored = np.ascontiguousarray(image[:, ::-1])
        detections = detector.detect(PERIOD_NS * index, mirrored, None, CAMERA)
        assert len(detections) == 21
    assert detector.contradicted
    assert "looks like a left one, right is stated" in (detector.doubt() or "")


def test_a_picture_without_a_hand_gives_no_detections(networks: Path) -> None:
    detector = BareHandDetector("right", networks)
    for index in range(30):
        assert len(detector.detect(PERIOD_NS * index, np.zeros((72, 128, 3), np.uint8), None, CAMERA)) == 0
    assert "No bare hand is seen" in (detector.doubt() or "")


def test_without_networks_the_command_is_named(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="run rehab-app camera models install"):
        HandLandmarker("right", tmp_path)
