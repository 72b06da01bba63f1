"""The automatic start: a still open hand is named through misses, bad depth and clutter; nothing else is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.complaint import Complaints
from rehab_app.tracking.open_hand import FRAMES, OpenHand
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64, Int64

PROTOCOL = load_protocol("thesis25")
UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
SECOND = 30
ALONG = np.array([1.0, 0.0, 0.0])
Seen = tuple[Detections, Int64]


def hand(side: Side, seed: int, middle_m: tuple[float, float, float] = (0.0, 0.02, 0.7)) -> Float64:
    """Markers of an open hand of some person, its back to the camera, (25, 3)."""
    rng = np.random.default_rng([seed, 1])
    model = MarkerModel(average_subject(PROTOCOL, side, rng.uniform(0.165, 0.21)), PROTOCOL)
    turn = Rotation.from_rotvec([*rng.uniform(-0.3, 0.3, 2), rng.uniform(-0.5, 0.5)]).as_matrix()
    points = model.positions(rng.normal(0.0, 0.07, len(JOINTS))) + rng.normal(0.0, 0.0015, (25, 3))
    return points @ (turn @ UPRIGHT).T + np.array(middle_m) - [0.0, -0.06, 0.0]


def shot(index: int, points_m: Float64, rng: np.random.Generator, false: int = 4) -> Seen:
    """What a poor sensor makes of markers: 6 % missed, 6 % without depth, 3 % at a wrong one, false blobs."""
    owner = np.flatnonzero(rng.random(len(points_m)) > 0.06)
    pixel = KINECT.project(points_m[owner]) + rng.normal(0.0, 0.9, (len(owner), 2))
    depth = points_m[owner, 2] + rng.normal(0.0, 0.0015, len(owner))
    beside = KINECT.project(points_m).mean(axis=0) + rng.normal(0.0, 70.0, (false, 2))
    pixel = np.vstack([pixel, beside])
    depth = np.concatenate([depth, 0.7 + rng.normal(0.0, 0.03, false)])
    wrong = rng.random(len(depth)) < 0.03
    depth = depth + wrong * rng.choice([-1.0, 1.0], len(depth)) * rng.uniform(0.02, 0.15, len(depth))
    depth[rng.random(len(depth)) < 0.06] = np.nan
    order = rng.permutation(len(depth))
    count = len(depth)
    detections = lifted(
        round(index * 1e9 / 30),
        pixel[order],
        depth[order],
        KINECT,
        pixel_std_px=np.ones(count),
        depth_std_m=np.full(count, 0.002),
        similarity=np.ones(count),
    )
    return detections, np.concatenate([owner, np.full(false, -1)])[order]


def started(open_hand: OpenHand, points_m: Float64, seed: int = 0, step_m: float = 0.0) -> list[Seen] | None:
    """What was seen until the hand counted as shown; None if it did not within a second."""
    rng = np.random.default_rng([seed, 2])
    seen: list[Seen] = []
    for index in range(SECOND):
        seen.append(shot(index, points_m + index * step_m * ALONG, rng))
        if open_hand.watch(seen[-1][0]):
            return seen
    return None


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_still_open_hand_is_named_within_a_second_under_a_poor_sensor(side: Side) -> None:
    named = 0
    for seed in range(6):
        open_hand = OpenHand(PROTOCOL, side)
        seen = started(open_hand, hand(side, seed), seed)
        match = open_hand.first_match
        if seen is None or match is None:
            continue
        assert len(open_hand.labelled) == FRAMES
        start_ns = open_hand.labelled[0][0]
        (owner,) = [owner for one, owner in seen if one.t_capture_ns == start_ns]
        given = np.flatnonzero(match >= 0)
        assert len(given) >= 18
        assert (owner[match[given]] == given).all()
        named += 1
    assert named >= 5


def test_a_fist_is_no_open_hand() -> None:
    model = MarkerModel(average_subject(PROTOCOL, "right"), PROTOCOL)
    joints = np.zeros(len(JOINTS))
    for row, name in enumerate(JOINTS):
        joints[row] = 1.3 if name.endswith(("_pip", "mcp_flexion")) else 0.0
    fist = model.positions(joints) @ UPRIGHT.T + [0.0, 0.0, 0.7]
    assert started(OpenHand(PROTOCOL, "right"), fist) is None


@pytest.mark.parametrize("seed", range(3))
def test_the_other_hand_is_refused_and_said(seed: int) -> None:
    open_hand = OpenHand(PROTOCOL, "right")
    assert started(open_hand, hand("left", seed), seed) is None
    said = Complaints(PROTOCOL, "right").searching(open_hand.spots_m)
    assert said == "This looks like a left hand; a right hand was announced."


@pytest.mark.parametrize("other", ["right", "left"])
def test_two_hands_are_refused_and_said(other: Side) -> None:
    both = np.vstack([hand("right", 3, (-0.14, 0.0, 0.7)), hand(other, 4, (0.14, 0.0, 0.72))])
    open_hand = OpenHand(PROTOCOL, "right")
    assert started(open_hand, both) is None
    said = Complaints(PROTOCOL, "right").searching(open_hand.spots_m)
    assert said == "Two hands with markers are in view: take one away."


@pytest.mark.parametrize("other", ["right", "left"])
def test_a_second_hand_that_is_hidden_in_part_keeps_it_from_starting(other: Side) -> None:
    first, second = hand("right", 1, (-0.1, 0.0, 0.7)), hand(other, 8, (0.1, 0.0, 0.72))
    assert started(OpenHand(PROTOCOL, "right"), first, 1) is not None
    assert started(OpenHand(PROTOCOL, "right"), np.vstack([first, second[:18]]), 1) is None


def test_markers_that_are_missing_are_named() -> None:
    gone = [PROTOCOL.names.index(name) for name in ("index_tip", "ring_pip", "wrist")]
    open_hand = OpenHand(PROTOCOL, "right")
    assert started(open_hand, np.delete(hand("right", 2), gone, axis=0)) is None
    said = Complaints(PROTOCOL, "right").searching(open_hand.spots_m)
    assert said.startswith("These markers are not seen: ")
    assert {"index_tip", "ring_pip", "wrist"} == set(said[:-1].partition(": ")[2].split(", "))


def test_a_hand_that_moves_is_asked_to_keep_still() -> None:
    open_hand = OpenHand(PROTOCOL, "right")
    assert started(open_hand, hand("right", 1), step_m=0.02) is None
    said = Complaints(PROTOCOL, "right").searching(open_hand.spots_m, 27)
    assert said == "Hold the open hand still for a second: the 27 blobs in view are moving."


@pytest.mark.parametrize("seed", range(3))
def test_clutter_is_no_hand(seed: int) -> None:
    rng = np.random.default_rng([seed, 3])
    clutter = np.array([0.0, 0.0, 0.7]) + rng.uniform(-1.0, 1.0, (30, 3)) * [0.12, 0.12, 0.02]
    assert started(OpenHand(PROTOCOL, "right"), clutter, seed) is None


def test_blank_captures_do_not_disturb_and_nothing_at_all_is_nothing() -> None:
    open_hand, points = OpenHand(PROTOCOL, "right"), hand("right", 5)
    rng = np.random.default_rng(5)
    assert len(open_hand.spots_m) == 0
    shown = False
    for index in range(SECOND):
        one, _ = shot(index, points, rng)
        blank = index in (8, 9)
        shown = shown or open_hand.watch(one.rows(np.empty(0, np.int64)) if blank else one)
    assert shown
    nothing = OpenHand(PROTOCOL, "right")
    for index in range(SECOND):
        assert not nothing.watch(shot(index, points, rng)[0].rows(np.empty(0, np.int64)))
    assert not nothing.found
