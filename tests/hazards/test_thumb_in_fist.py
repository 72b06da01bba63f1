"""Hazard 8: the thumb in the fist, the nail in the palm. Skins keep 5 mm, and the thumb closes last."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from robot_iface.kinematics import average_hand, forward
from robot_iface.motion import QuinticPath, check_path
from robot_iface.motion.clearance import CLEARANCE_M, least_clearance_m, too_close, whole_hand
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import FINGERS, Float64, ReferencePath, Side

DEVICE = device_capabilities()
LIMITS = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)
LENGTHS_M = (0.16, 0.175, 0.189, 0.21)
SIDES: tuple[Side, ...] = ("left", "right")
OPEN = {"mcp_flexion": 2.0, "pip": 2.0}
RELAXED = {"mcp_flexion": 25.0, "pip": 33.0}
FULL_FIST = {"mcp_flexion": 88.0, "pip": 100.0}
EASY_FIST = {"mcp_flexion": 75.0, "pip": 85.0}
ACROSS = {
    "thumb_cmc_flexion": 22.0,
    "thumb_cmc_abduction": -24.0,
    "thumb_mcp_flexion": 39.0,
    "thumb_ip": 74.0,
}


def driven(fingers: dict[str, float], thumb: dict[str, float]) -> Float64:
    return np.deg2rad([thumb.get(name, fingers.get(name.split("_", 1)[1], 0.0)) for name in DRIVEN])


def posture(fingers: dict[str, float], thumb: dict[str, float] | None = None) -> Float64:
    straight = {name: 2.0 for name in DRIVEN if name.startswith("thumb")}
    return driven(fingers, straight | (thumb or {}))


def path(*postures: Float64, side: Side = "right", leg_s: float = 12.0) -> ReferencePath:
    """Straight legs between postures, each a smooth step."""
    shares = np.linspace(0.0, 1.0, round(leg_s * 10) + 1)[1:]
    blend = (shares**3 * (10.0 - 15.0 * shares + 6.0 * shares**2))[:, None]
    rows = [postures[0][None]]
    rows += [before + blend * (after - before) for before, after in pairwise(postures)]
    q = np.concatenate(rows)
    return ReferencePath(DRIVEN, 0.1 * np.arange(len(q)), q, "0" * 64, side)


def first(reference: ReferencePath, length_m: float) -> Any:
    return check_path(QuinticPath(reference), LIMITS, 0.5, 0.001, average_hand(length_m, reference.side))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("length_m", LENGTHS_M)
def test_an_easy_fist_passes_and_a_full_one_names_tip_time_value_and_bound(
    length_m: float, side: Side
) -> None:
    assert first(path(posture(RELAXED), posture(EASY_FIST), side=side), length_m) is None
    found = first(path(posture(RELAXED), posture(FULL_FIST), side=side), length_m)
    assert found is not None
    assert found.quantity == "clearance"
    assert found.joint.endswith("tip to palm")
    assert 0.0 < found.value < found.bound == CLEARANCE_M
    sentence = found.sentence()
    assert f"at {found.t_s:.2f} s, bound 5.0 mm: trim the movement there or close that digit less" in sentence


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("length_m", LENGTHS_M)
def test_fingers_never_close_over_the_thumb(length_m: float, side: Side) -> None:
    """The thumb goes across the palm first, then the fingers close: refused before they reach it."""
    tucked = path(posture(OPEN), posture(OPEN, ACROSS), posture(EASY_FIST, ACROSS), side=side)
    found = first(tucked, length_m)
    assert found is not None
    assert found.quantity in ("clearance", "closing order")
    assert "thumb" in found.joint
    assert found.t_s > 24.0  # not while the thumb moves alone
    fingers_then_thumb = path(posture(OPEN), posture(EASY_FIST), side=side)
    assert first(fingers_then_thumb, length_m) is None


def test_the_order_is_told_from_the_distance() -> None:
    """Without any distance to keep, the thumb under a finger is still refused, and nothing else is."""
    hand = average_hand()
    under = whole_hand(posture(EASY_FIST, ACROSS)[None], DRIVEN)
    found = too_close(hand, under, bound_m=-1.0)
    assert found is not None
    assert found.between.startswith("thumb under ")
    assert np.isnan(found.value_m)
    for fingers in (OPEN, RELAXED, EASY_FIST):
        assert too_close(hand, whole_hand(posture(fingers)[None], DRIVEN), bound_m=-1.0) is None


def test_the_sentence_of_the_order_says_what_to_do() -> None:
    slow = path(posture(OPEN), posture(OPEN, ACROSS), posture(EASY_FIST, ACROSS))
    found = first(slow, 0.189)
    assert found is not None
    order = type(found)("thumb under index", "closing order", 3.0, float("nan"), 0.005).sentence()
    assert order.startswith("thumb under index at 3.00 s")
    assert order.endswith("close the fingers before the thumb")


@pytest.mark.parametrize("seed", range(6))
def test_distances_are_those_of_densely_sampled_bones_and_mirror_with_the_side(seed: int) -> None:
    rng = np.random.default_rng(seed)
    driven_rad = rng.uniform(DEVICE.q_min_rad, DEVICE.q_max_rad, (1, len(DRIVEN)))
    joints = whole_hand(driven_rad, DRIVEN)
    left, right = (least_clearance_m(average_hand(0.189, side), joints) for side in SIDES)
    assert left == pytest.approx(right, abs=1e-12)
    points = forward(average_hand(), joints).landmarks_m[0, :20].reshape(5, 4, 3)
    shares = np.linspace(0.0, 1.0, 120)[:, None]
    radii = (0.009, 0.008, 0.0065)
    for digit, finger in enumerate(FINGERS, start=1):
        least = np.inf
        for bone, radius in ((1, 0.010), (2, 0.0085)):
            thumb = points[0, bone] + shares * (points[0, bone + 1] - points[0, bone])
            for other in range(3):
                phalanx = points[digit, other] + shares * (points[digit, other + 1] - points[digit, other])
                gap = np.linalg.norm(thumb[:, None] - phalanx[None], axis=2).min()
                least = min(least, gap - radius - radii[other])
        assert right[f"thumb to {finger}"] == pytest.approx(least, abs=5e-4)


def test_a_robot_that_is_not_worn_has_no_skin_to_keep() -> None:
    full = path(posture(RELAXED), posture(FULL_FIST))
    assert check_path(QuinticPath(full), LIMITS, 0.5, 0.001) is None
