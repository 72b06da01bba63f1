from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sessions.metrics.movement import active_rows, movement_time, path_ratio, peak_speed
from sessions.metrics.tracking import pooled_rmse, rmse

T = np.arange(0.0, 4.0, 0.001)
UNKNOWN = np.full(T.size, np.nan)


def test_a_delayed_sine() -> None:
    value = rmse(np.sin(np.pi * (T - 0.1)), np.sin(np.pi * T), UNKNOWN).value
    assert value == pytest.approx(math.sqrt(2) * abs(math.sin(math.pi * 0.1 / 2)), abs=1e-6)
    assert value == pytest.approx(0.221232, abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.1, 3.0), st.floats(0.0, 0.4), st.floats(0.01, 5.0))
def test_any_delayed_sine(frequency: float, delay_s: float, amplitude: float) -> None:
    omega = 2 * np.pi * frequency
    t = np.arange(2000) / 2000 * (3 / frequency)
    patient, therapist = amplitude * np.sin(omega * (t - delay_s)), amplitude * np.sin(omega * t)
    expected = math.sqrt(2) * amplitude * abs(math.sin(omega * delay_s / 2))
    assert rmse(patient, therapist, np.zeros(2000)).value == pytest.approx(
        expected, abs=1e-9 * amplitude + 1e-12
    )


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
def test_a_constant_offset_is_its_length(offset: list[float]) -> None:
    path = np.random.default_rng(1).normal(size=(200, 3))
    value = rmse(path + np.array(offset), path, np.zeros(200)).value
    assert value == pytest.approx(float(np.linalg.norm(offset)), abs=1e-12)


def test_gaps_take_no_part_and_their_absence_is_not_a_zero() -> None:
    patient = np.where(T < 2.0, np.nan, 1.0)
    assert rmse(patient, np.zeros(T.size), UNKNOWN).value == 1.0
    nothing = rmse(np.full(T.size, np.nan), np.zeros(T.size), UNKNOWN)
    assert math.isnan(nothing.value)
    assert "no sample" in nothing.reason


def test_the_interval_covers_a_calibration_that_is_off() -> None:
    rng, covered = np.random.default_rng(5), 0
    for _ in range(300):
        bias = rng.normal(0.0, 0.02)
        interval = rmse(np.full(100, 0.1 + bias), np.zeros(100), np.full(100, 0.02)).interval
        assert interval is not None
        covered += interval[0] <= 0.1 <= interval[1]
    assert 0.91 <= covered / 300 <= 0.99


def test_pooling_is_the_root_mean_square_and_needs_every_interval() -> None:
    one = rmse(np.full(10, 3.0), np.zeros(10), np.full(10, 0.1))
    other = rmse(np.full(10, 4.0), np.zeros(10), np.full(10, np.nan))
    pooled = pooled_rmse([one, other])
    assert pooled.value == pytest.approx(math.sqrt(12.5))
    assert pooled.interval is None
    assert pooled_rmse([one, one]).interval == pytest.approx(one.interval)


def test_path_ratios() -> None:
    line = np.outer(np.linspace(0, 1, 50), [1.0, 2.0, -1.0])
    assert path_ratio(line).value == pytest.approx(1.0)
    angle = np.linspace(0, np.pi, 4001)
    half = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert path_ratio(half).value == pytest.approx(1.570796, abs=1e-6)
    circle = np.stack([np.cos(2 * angle), np.sin(2 * angle)], axis=1)
    closed = path_ratio(circle)
    assert math.isnan(closed.value)
    assert "returns" in closed.reason
    assert "nothing moved" in path_ratio(np.zeros((5, 3))).reason
    assert "gap" in path_ratio(np.full((5, 3), np.nan)).reason


def test_minimum_jerk_peak_and_time() -> None:
    tau = np.arange(1001) / 1000
    speed = 0.08 * 30 * tau**2 * (1 - tau) ** 2
    assert peak_speed(speed).value / 0.08 == pytest.approx(1.875)
    share = math.sqrt(0.05) / 4
    onset = (1 - math.sqrt(1 - 4 * share)) / 2
    assert movement_time(speed, 1000.0).value == pytest.approx(1 - 2 * onset, abs=2e-3)
    assert "nothing moved" in movement_time(np.zeros(10), 100.0).reason
    assert active_rows(np.empty(0)) == slice(0, 0)
