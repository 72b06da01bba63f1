"""The thumb gives way by little, smoothly, only where skins come too close, and never to lower the bound."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from rehab_app.hand.exercise_postures import posture_rad
from rehab_app.therapy.reference_bumps import bumps, windows
from rehab_app.therapy.reference_clearance import MARGIN_M, MOST_RAD, keep_clearance
from robot_iface.kinematics import average_hand
from robot_iface.motion import QuinticPath, check_path
from robot_iface.motion.clearance import CLEARANCE_M, least_clearance_m, too_close, whole_hand
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import Hull, ReferencePath, Side, joint_index
from sessions.records.fields import Float64

DEVICE = device_capabilities()
LIMITS = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)
T_S = np.linspace(0.0, 12.0, 601)
THUMB = [at for at, name in enumerate(DRIVEN) if name.startswith("thumb")]
CLOSE = ("three-jaw pinch", "cylinder", "loose", "thumb to index")
REACHED_S = 0.7


def there_and_back(posture: str, seed: int | None = None) -> Float64:
    """Angles (K, J) from open to a posture of the library and back, strictly inside the limits."""
    inset = np.deg2rad(0.4)
    low, high = LIMITS.q_min_rad + inset, LIMITS.q_max_rad - inset
    ends = [np.clip(posture_rad(name)[joint_index(DRIVEN)], low, high) for name in ("open", posture)]
    if seed is not None:
        ends[1] = np.clip(
            ends[1] + np.deg2rad(2.0) * np.random.default_rng(seed).standard_normal(12), low, high
        )
    phase = np.clip((T_S - 1.0) / 10.0, 0.0, 1.0)
    share = (0.5 - 0.5 * np.cos(2.0 * np.pi * phase))[:, None]
    return ends[0] + share * (ends[1] - ends[0])


def keep(path: Float64, side: Side = "right", length_m: float = 0.189, **changes: Any) -> Any:
    return keep_clearance(path, DRIVEN, average_hand(length_m, side), replace(LIMITS, **changes), T_S)


def thumb_m(path: Float64, length_m: float = 0.189) -> float:
    found = least_clearance_m(average_hand(length_m), whole_hand(path, DRIVEN))
    return min(value for pair, value in found.items() if pair.startswith("thumb"))


@pytest.fixture(scope="module", params=CLOSE)
def led(request: pytest.FixtureRequest) -> tuple[Float64, Float64, tuple[str, ...]]:
    before = there_and_back(request.param)
    return (before, *keep(before))


def test_clearance_is_kept_between_the_knots_too(led: tuple[Float64, Float64, tuple[str, ...]]) -> None:
    before, after, notes = led
    assert thumb_m(before) < CLEARANCE_M
    assert CLEARANCE_M <= thumb_m(after) < CLEARANCE_M + 2.0 * MARGIN_M, "kept, and no more than that"
    spline = QuinticPath(ReferencePath(DRIVEN, T_S, after, "0" * 64, "right"))
    assert check_path(spline, LIMITS, 0.25, 0.01, average_hand()) is None
    (note,) = notes
    change = np.abs(after - before)
    row, joint = divmod(int(change.argmax()), len(DRIVEN))
    assert DRIVEN[joint] in note
    assert f"{np.rad2deg(change[row, joint]):.1f} deg" in note
    assert f"at {T_S[row]:.1f} s" in note


def test_only_the_thumb_moves_only_near_the_approach_and_little(
    led: tuple[Float64, Float64, tuple[str, ...]],
) -> None:
    before, after, _ = led
    change = after - before
    assert not np.delete(change, THUMB, axis=1).any()
    assert 0.0 < np.abs(change).max() <= MOST_RAD
    near = np.array([thumb_m(row[None]) < CLEARANCE_M + 0.0001 for row in before])
    first, last = T_S[near][[0, -1]]
    far = (T_S < first - REACHED_S) | (T_S > last + REACHED_S)
    assert far.any()
    np.testing.assert_array_equal(after[far], before[far])


def test_the_change_is_smooth_and_stays_in_range(led: tuple[Float64, Float64, tuple[str, ...]]) -> None:
    before, after, _ = led
    speed = np.diff(after - before, axis=0) / np.diff(T_S)[:, None]
    assert np.abs(speed).max() < np.deg2rad(30.0)
    assert np.abs(np.diff(speed, axis=0)).max() < np.deg2rad(4.0), "no corner"
    assert (after > LIMITS.q_min_rad).all()
    assert (after < LIMITS.q_max_rad).all()


@pytest.mark.parametrize(("seed", "length_m"), [(1, 0.16), (2, 0.175), (3, 0.21)])
def test_noise_and_hands_of_other_sizes(seed: int, length_m: float) -> None:
    before = there_and_back("three-jaw pinch", seed)
    after, _ = keep(before, length_m=length_m)
    found = too_close(average_hand(length_m), whole_hand(after, DRIVEN))
    assert found is None
    assert np.abs(after - before).max() <= MOST_RAD


def test_a_path_that_keeps_clear_is_returned_as_it_is() -> None:
    before = there_and_back("tabletop")
    assert thumb_m(before) > CLEARANCE_M
    after, notes = keep(before)
    assert after is before
    assert notes == ()


def test_what_was_cleared_once_is_left_alone() -> None:
    once, _ = keep(there_and_back("cylinder"))
    again, notes = keep(once)
    assert again is once
    assert notes == ()


def test_both_sides_are_led_alike() -> None:
    before = there_and_back("cylinder")
    (right, _), (left, _) = keep(before, "right"), keep(before, "left")
    np.testing.assert_allclose(left, right, atol=1e-9)


def test_a_fist_over_the_thumb_is_left_for_the_rehearsal_to_refuse() -> None:
    before = there_and_back("fist")
    share = (before[:, -1:] - before[0, -1]) / (before[:, -1].max() - before[0, -1])
    across = np.deg2rad([22.0, -24.0, 39.0, 74.0])
    before[:, THUMB] += share * (across - before[0, THUMB] - share * (before[300, THUMB] - before[0, THUMB]))
    after, (note,) = keep(before)
    assert after is before
    assert note.startswith("Thumb to ")
    assert " comes to -" in note
    assert "more than 10 deg" in note


def test_no_room_in_the_range_or_a_shared_hull_leaves_it_as_shown() -> None:
    before = there_and_back("cylinder")
    narrow: dict[str, Any] = {"q_min_rad": LIMITS.q_min_rad.copy(), "q_max_rad": LIMITS.q_max_rad.copy()}
    narrow["q_min_rad"][THUMB] = before[:, THUMB].min(axis=0) - 0.006
    narrow["q_max_rad"][THUMB] = before[:, THUMB].max(axis=0) + 0.006
    after, notes = keep(before, **narrow)
    assert (after is before) == ("left as shown" in notes[0])
    assert (after > narrow["q_min_rad"]).all()
    assert (after < narrow["q_max_rad"]).all()
    corners = np.array([[-1.0, -1.0], [3.0, -1.0], [3.0, 3.0], [-1.0, 3.0]])
    hulls = tuple(Hull((DRIVEN[at], DRIVEN[at + 1]), corners) for at in (0, 2))
    same, told = keep(before, hulls=hulls)
    assert same is before
    assert told == ()


@pytest.mark.parametrize("count", [2, 3, 17])
def test_bumps_sum_to_one_and_rest_at_both_ends(count: int) -> None:
    t_s = np.linspace(3.0, 5.0, 801)
    shapes = bumps(t_s, count)
    np.testing.assert_allclose(shapes.sum(axis=1), 1.0, atol=1e-12)
    weights = np.random.default_rng(count).standard_normal(count)
    slope = np.gradient(shapes @ weights, t_s)
    assert abs(slope[[0, -1]]).max() < 0.05 * abs(slope).max() + 1e-9
    assert windows(t_s)[0].start == 0
    assert windows(t_s)[-1].stop == len(t_s)
