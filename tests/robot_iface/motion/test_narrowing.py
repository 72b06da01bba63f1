"""Less range: never wider, never faster, and as near to what is wanted as that allows."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.motion import QuinticPath, narrowed, unchanged
from robot_iface.safety import shipped_limits
from robot_iface.types import ReferencePath

NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
rows = st.lists(st.floats(-0.5, 2.0), min_size=3, max_size=3).map(np.array)


def path() -> ReferencePath:
    t_s = np.linspace(0.0, 4.0, 81)
    q = 0.6 - 0.4 * np.cos(np.pi * t_s[:, None] / 2.0) * np.array([1.0, 0.8, 0.5])
    return ReferencePath(NAMES, t_s, q, "digest", "right")


@given(first=rows, second=rows, floor=rows, ceiling=rows)
@settings(max_examples=200, deadline=None)
def test_a_narrowed_range_lies_in_the_old_one_and_where_it_can_between_floor_and_ceiling(
    first: np.ndarray, second: np.ndarray, floor: np.ndarray, ceiling: np.ndarray
) -> None:
    low, high = np.minimum(first, second), np.maximum(first, second)
    narrow = narrowed(low, high, floor, ceiling)
    new_low, new_high = narrow.apply(low), narrow.apply(high)
    assert (narrow.scale >= 0.0).all()
    assert (narrow.scale <= 1.0).all()
    assert (new_low >= low - 1e-9).all()
    assert (new_high <= high + 1e-9).all()
    meets = (floor <= high) & (ceiling >= low) & (floor <= ceiling) & (high - low > 1e-6)
    assert (new_low[meets] >= np.maximum(low, floor)[meets] - 1e-9).all()
    assert (new_high[meets] <= np.minimum(high, ceiling)[meets] + 1e-9).all()
    room = meets & (floor <= low) & (ceiling >= high)
    np.testing.assert_allclose(narrow.scale[room], 1.0, atol=1e-12)


def test_a_joint_that_does_not_move_stays_where_it_is() -> None:
    here = np.array([0.0, 0.4, 1.0])
    narrow = narrowed(here, here, np.full(3, 0.2), np.full(3, 0.8))
    np.testing.assert_array_equal(narrow.apply(here), here)


def test_a_path_within_less_range_is_the_same_movement_scaled() -> None:
    whole = QuinticPath(path())
    low, high = whole.span_rad()
    np.testing.assert_allclose(low, 0.6 - 0.4 * np.array([1.0, 0.8, 0.5]), atol=1e-6)
    narrow = narrowed(low, high, low + 0.1, high - 0.05)
    part = whole.within(narrow)
    s = np.linspace(0.0, 4.0, 97)
    np.testing.assert_allclose(part.sample(s), narrow.apply(whole.sample(s)), atol=1e-12)
    np.testing.assert_allclose(part.sample(s, 1), narrow.scale * whole.sample(s, 1), atol=1e-12)
    for place in s.tolist():
        mine, its = part.evaluate(place, 0.4, 0.3), whole.evaluate(place, 0.4, 0.3)
        np.testing.assert_allclose(mine.q_rad, narrow.apply(its.q_rad), atol=1e-12)
        np.testing.assert_allclose(mine.dq_rad_s, narrow.scale * its.dq_rad_s, atol=1e-12)
        np.testing.assert_allclose(mine.ddq_rad_s2, narrow.scale * its.ddq_rad_s2, atol=1e-12)
    assert (part.sample(s).min(axis=0) >= low + 0.1 - 1e-6).all()
    again = whole.within(unchanged(3))
    np.testing.assert_array_equal(again.start_rad(), whole.start_rad())


def test_the_way_back_is_bounded_by_the_limits_of_the_other_direction() -> None:
    """Closing at 60 deg/s is allowed; backwards the same stretch opens, at 15 deg/s for a spastic hand."""
    limits = shipped_limits(NAMES, np.zeros(3), np.full(3, 1.5), spastic=True)
    for sign in (1.0, -1.0):
        t_s = np.linspace(0.0, 4.0, 81)  # one way only: it closes, or it opens
        q = 0.6 - sign * 0.4 * np.cos(np.pi * t_s[:, None] / 4.0) * np.array([1.0, 0.8, 0.5])
        whole = QuinticPath(ReferencePath(NAMES, t_s, q, "digest", "right"))
        back = whole.fastest_back(limits)
        slope = whole.sample(np.linspace(0.0, 4.0, 40_001), 1) * -back
        share = np.maximum(slope / limits.flexion_speed_rad_s, -slope / limits.extension_speed_rad_s)
        assert 0.99 < float(share.max()) <= 1.0
    one_way = ReferencePath(NAMES, np.linspace(0.0, 4.0, 9), np.full((9, 3), 0.5), "digest", "right")
    assert QuinticPath(one_way).fastest_back(limits) > 1e3
