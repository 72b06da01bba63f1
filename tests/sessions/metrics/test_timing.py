"""Delay, shape and offset: each is found where it was put, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from sessions.metrics.timing import decompose, warped_distance
from sessions.metrics.tracking import rmse

T_S = np.arange(0.0, 8.0, 0.01)


def movement(t_s: np.ndarray) -> np.ndarray:
    closing = 0.5 - 0.5 * np.cos(2 * np.pi * t_s / 4.0)
    return np.stack([0.05 * closing, 0.02 * np.sin(2 * np.pi * t_s / 4.0), 0.03 * closing**2], axis=1)


def test_warping_distances_of_the_reference() -> None:
    assert warped_distance(np.array([1.0, 2, 3]), np.array([1.0, 2, 2, 3])) == 0.0
    assert warped_distance(np.array([0.0, 1, 2]), np.array([1.0, 2, 3])) == pytest.approx(2.0)


def test_error_of_a_delayed_sine() -> None:
    t_s = np.linspace(0.0, 10.0, 100_001)[:-1]
    delayed, reference = np.sin(np.pi * (t_s - 0.1)), np.sin(np.pi * t_s)
    assert rmse(delayed, reference, np.zeros(t_s.size)).value == pytest.approx(0.221232, abs=1e-6)


@pytest.mark.parametrize("delay_s", [-0.3, -0.1, 0.0, 0.12, 0.4])
def test_a_delay_is_a_delay_and_nothing_else(delay_s: float) -> None:
    found = decompose(T_S, movement(T_S - delay_s), movement(T_S))
    assert found.delay.value == pytest.approx(delay_s, abs=0.01)
    assert found.shape.value < 0.003
    assert found.offset.value < 0.003


def test_an_offset_is_an_offset_and_nothing_else() -> None:
    away = np.array([0.003, -0.004, 0.0])
    found = decompose(T_S, movement(T_S) + away, movement(T_S))
    assert found.offset.value == pytest.approx(0.005, abs=1e-9)
    assert found.delay.value == pytest.approx(0.0, abs=1e-9)
    assert found.shape.value == pytest.approx(0.0, abs=1e-9)


def test_another_shape_is_neither_late_nor_beside() -> None:
    rng = np.random.default_rng(71)
    wobble = 0.01 * np.sin(2 * np.pi * 1.5 * T_S + rng.uniform(0, 6))
    other = movement(T_S) + np.stack([0 * wobble, wobble, -wobble], axis=1)
    found = decompose(T_S, other, movement(T_S))
    assert 0.004 < found.shape.value < 0.0105
    assert abs(found.delay.value) < 0.05
    assert found.offset.value < 0.002


def test_gaps_are_left_out_and_too_little_is_nothing() -> None:
    patient = movement(T_S)
    patient[200:300] = np.nan
    assert decompose(T_S, patient, movement(T_S)).shape.value < 1e-3
    few = decompose(T_S[:20], movement(T_S[:20]), movement(T_S[:20]))
    assert np.isnan(few.shape.value)
    assert "0.4 s" in few.delay.reason


def test_rest_is_no_uneven_timing() -> None:
    rng = np.random.default_rng(72)
    t_s = np.arange(0.0, 12.0, 0.01)
    moved = movement(np.clip(t_s - 4.0, 0.0, 4.0))
    found = decompose(t_s, moved + rng.normal(0.0, 2e-4, moved.shape), moved)
    assert found.warp.value < 0.06
    hasty = decompose(t_s, movement(np.clip(1.25 * (t_s - 4.0), 0.0, 4.0)), moved)
    assert hasty.warp.value > 0.2
