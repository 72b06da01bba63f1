from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sessions.metrics.motion_range import NORM_TOTAL_RAD, joint_range, total_active_motion
from sessions.metrics.repetitions import cycles, main_movement
from sessions.metrics.spans import gap_free, uniform_spans

RATE = 60.0


def rise(peak: float, seconds: float = 6.0) -> tuple[np.ndarray, np.ndarray]:
    t = np.arange(round(seconds * RATE)) / RATE
    tau = np.clip((t - 1.0) / 1.0, 0, 1)
    return t, peak * (10 * tau**3 - 15 * tau**4 + 6 * tau**5)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.05, 2.0), st.floats(-0.5, 0.5))
def test_a_known_flexion_is_found_wherever_it_starts(peak: float, offset: float) -> None:
    t, angle = rise(peak)
    found = joint_range(t, angle + offset, np.zeros(t.size))
    assert found.width.value == pytest.approx(peak, abs=1e-3 * peak + 1e-6)
    assert found.low.value == pytest.approx(offset, abs=1e-3 * peak + 1e-6)


def test_noise_of_one_degree_moves_forty_degrees_by_less_than_two() -> None:
    t, angle = rise(np.deg2rad(40.0), 10.0)
    rng = np.random.default_rng(11)
    noise = np.deg2rad(1.0)
    for _ in range(20):
        found = joint_range(t, angle + rng.normal(0, noise, t.size), np.full(t.size, noise))
        assert np.rad2deg(found.width.value) == pytest.approx(40.0, abs=2.0)
        assert found.width.interval is not None
        assert found.width.interval[0] < np.deg2rad(40.0) < found.width.interval[1]


def test_one_wild_sample_is_no_range_of_motion() -> None:
    t, angle = rise(0.5)
    angle[200] = np.nan
    angle[203] += 0.3
    assert joint_range(t, angle, np.zeros(t.size)).width.value < 0.58


def test_interval_is_that_of_two_ends() -> None:
    t, angle = rise(1.0)
    found = joint_range(t, angle, np.full(t.size, 0.02))
    assert found.width.interval is not None
    assert found.width.interval[1] - found.width.value == pytest.approx(1.959964 * math.sqrt(2) * 0.02)
    assert joint_range(t, angle, np.full(t.size, np.nan)).width.interval is None


def test_never_seen_says_so() -> None:
    t, angle = rise(1.0)
    assert "never measured" in joint_range(t, np.full(t.size, np.nan), angle).width.reason


def test_total_active_motion_oracles() -> None:
    assert total_active_motion(np.deg2rad([85, 110, 65]), np.zeros(3)).value == pytest.approx(NORM_TOTAL_RAD)
    value = total_active_motion(np.deg2rad([60, 70, 30]), np.deg2rad([5, 10, 5])).value
    assert math.degrees(value) == pytest.approx(140.0)
    assert value / NORM_TOTAL_RAD == pytest.approx(0.538, abs=5e-4)
    assert total_active_motion(np.ones(3), np.array([-0.2, 0, 0])).value == pytest.approx(3.0)
    assert total_active_motion(np.array([np.nan, 1, 1]), np.zeros(3)).reason


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 8), st.floats(0.5, 1.5), st.floats(0.3, 1.5))
def test_repetitions_are_counted(count: int, period_s: float, amplitude: float) -> None:
    t = np.arange(round((count * period_s + 1.0) * RATE)) / RATE
    phase = np.clip((t - 0.5) / period_s, 0, count)
    found = cycles(t, amplitude * (1 - np.cos(2 * np.pi * phase)) / 2)
    assert found.count == count
    assert len(found.strokes_s) == 2 * count
    if count >= 2:
        assert found.rate_hz == pytest.approx(1 / period_s, rel=0.02)


@pytest.mark.parametrize("noise", [0.0, 1e-4, 5e-3])
def test_a_held_hand_is_counted_once_and_at_the_middle_of_the_hold(noise: float) -> None:
    t = np.arange(0.0, 24.0, 1 / RATE)
    phase = (t % 4.0) / 4.0
    tau = np.clip(np.where(phase < 0.5, phase, phase - 0.5) / 0.35, 0.0, 1.0)
    rise_and_hold = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    held = np.where(phase < 0.5, rise_and_hold, 1.0 - rise_and_hold)
    found = cycles(t, held + np.random.default_rng(1).normal(0.0, 1.0, t.size) * noise)
    assert found.count == 6
    assert found.rate_hz == pytest.approx(0.25, rel=2e-3)
    assert len(found.strokes_s) == 12


def test_tremor_is_no_repetition_and_a_gap_is_not_bridged() -> None:
    t = np.arange(600) / RATE
    assert cycles(t, np.deg2rad(3.0) * np.sin(2 * np.pi * 5 * t)).count == 0
    broken = (1 - np.cos(2 * np.pi * t / 5)) / 2
    broken[120:180] = np.nan  # the first peak lies in the gap
    assert cycles(t, broken).count == 1
    assert cycles(t, np.full(t.size, np.nan)).count == 0


def test_main_movement_closes_with_positive_sign() -> None:
    t = np.linspace(0, 10, 300)
    closing = np.sin(t)
    joints = np.stack([closing, 0.5 * closing, -0.1 * closing, np.full(300, np.nan)], axis=1)
    movement = main_movement(joints, np.array([1.0, 1.0, 0.0, 1.0]))
    assert np.corrcoef(movement, closing)[0, 1] == pytest.approx(1.0)


def test_spans_stop_at_gaps_and_at_time_that_stands_still() -> None:
    t = np.array([0, 1, 2, 3, 10, 11, 12, 12, 13], dtype=float)
    assert gap_free(t, np.ones(9, dtype=bool)) == [slice(0, 4), slice(4, 7), slice(7, 9)]
    valid = np.array([1, 1, 0, 1, 1, 1, 1, 1, 1], dtype=bool)
    assert gap_free(t, valid)[0] == slice(0, 2)
    assert gap_free(t[:1], valid[:1]) == []
    assert uniform_spans(t, t) == []


def test_a_uniform_span_keeps_what_it_was_given() -> None:
    t = np.arange(100) / 30
    values = np.stack([t, 2 * t], axis=1)
    values[50] = np.nan
    first, second = uniform_spans(t, values)
    assert first.rate_hz == pytest.approx(30.0)
    np.testing.assert_allclose(first.values, values[:50], atol=1e-12)
    assert second.t_s[0] == pytest.approx(51 / 30)
