"""What noise does to numbers of strokes: strokes whose truth is known, with noise of a known size."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sessions.metrics.filtering import low_pass, speed_m_s
from sessions.metrics.metric import Estimate
from sessions.metrics.stroke_noise import NOISE_TAILS, noise_reach
from sessions.metrics.strokes import NOISE_SPEEDS, StrokeValues, noise_speed_m_s, over_strokes, stroke_values

RATE_HZ, STROKE_S, WINDOW_S, STROKES = 30.0, 1.4, 2.0, 8
TIMES_S = np.arange(round(STROKES * WINDOW_S * RATE_HZ) + 1) / RATE_HZ
STARTS_S = WINDOW_S * np.arange(STROKES)
WINDOWS_S = np.column_stack((STARTS_S, STARTS_S + WINDOW_S))


def minimum_jerk(tau: np.ndarray) -> np.ndarray:
    held = np.clip(tau, 0.0, 1.0)
    return held**3 * (10.0 - 15.0 * held + 6.0 * held**2)


def path_m(chord_m: float, *, out_and_back: bool) -> np.ndarray:
    """Strokes along one axis with a rest before and after each, (N, 3)."""
    travel = np.zeros_like(TIMES_S)
    for number, start in enumerate(STARTS_S):
        tau = (TIMES_S - start - 0.5 * (WINDOW_S - STROKE_S)) / STROKE_S
        if out_and_back:
            travel += minimum_jerk(2.0 * tau) - minimum_jerk(2.0 * tau - 1.0)
        else:
            travel += minimum_jerk(tau) * (1.0 if number % 2 == 0 else -1.0)
    return np.column_stack((chord_m * travel, np.full_like(travel, 0.05), np.zeros_like(travel)))


def mean(values: list[StrokeValues], name: str) -> float:
    return over_strokes([getattr(item, name) for item in values]).value


def covered(chord_m: float, noise_m: float, *, out_and_back: bool) -> dict[str, float]:
    """By number: the share of 20 recordings whose interval holds the truth."""
    clean = path_m(chord_m, out_and_back=out_and_back)
    true = stroke_values(TIMES_S, clean, WINDOWS_S)
    held = dict.fromkeys(NOISE_TAILS, 0)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        noisy = clean + rng.normal(0.0, noise_m, clean.shape)
        values = stroke_values(TIMES_S, noisy, WINDOWS_S, noise_m)
        reach = noise_reach(values, noise_m, rng)
        for name in NOISE_TAILS:
            found = over_strokes([getattr(item, name) for item in values], reach[name])
            truth = mean(true, name)
            if found.interval is None and math.isnan(truth):
                held[name] += 1  # a path that comes back has no ratio
            elif found.interval is not None:
                held[name] += found.interval[0] <= truth <= found.interval[1]
    return {name: number / 20 for name, number in held.items()}


@pytest.mark.parametrize("noise_m", [0.0001, 0.0003, 0.0005])
@pytest.mark.parametrize("out_and_back", [False, True])
def test_intervals_hold_the_truth_behind_the_noise(noise_m: float, out_and_back: bool) -> None:
    shares = covered(0.08, noise_m, out_and_back=out_and_back)
    assert min(shares.values()) >= 0.9, shares


@pytest.mark.parametrize("noise_m", [0.0003, 0.0005])
def test_rest_in_noise_is_no_movement(noise_m: float) -> None:
    clean = path_m(0.08, out_and_back=False)
    noisy = clean + np.random.default_rng(7).normal(0.0, noise_m, clean.shape)
    truth = mean(stroke_values(TIMES_S, clean, WINDOWS_S), "movement_time")
    known = mean(stroke_values(TIMES_S, noisy, WINDOWS_S, noise_m), "movement_time")
    unknown = mean(stroke_values(TIMES_S, noisy, WINDOWS_S), "movement_time")
    assert abs(known - truth) < 0.5 * abs(unknown - truth)


def test_without_noise_nothing_is_added() -> None:
    values = stroke_values(TIMES_S, path_m(0.08, out_and_back=False), WINDOWS_S, 0.0)
    rng = np.random.default_rng(1)
    two_frames = {"movement_time": (-2.0 / RATE_HZ, 2.0 / RATE_HZ)}
    nothing = dict.fromkeys(NOISE_TAILS, (0.0, 0.0))
    assert noise_reach(values, 0.0, rng) == {**nothing, **two_frames}
    assert noise_reach(values, math.nan, rng) == nothing
    assert noise_reach([], 0.001, rng) == nothing
    assert values == stroke_values(TIMES_S, path_m(0.08, out_and_back=False), WINDOWS_S)


def test_the_interval_reaches_to_both_sides_of_what_noise_moved() -> None:
    values = [Estimate(1.0), Estimate(2.0), Estimate(3.0)]
    low, high = over_strokes(values).interval or (math.nan, math.nan)
    assert over_strokes(values, (0.0, 0.5)) == Estimate(2.0, (low - 0.5, high))
    assert over_strokes(values, (-0.5, 0.25)) == Estimate(2.0, (low - 0.25, high + 0.5))


def test_a_stroke_slower_than_the_noise_is_none() -> None:
    still = noise_speed_m_s(0.002, RATE_HZ)
    slow = path_m(0.006, out_and_back=False)
    assert 1.875 * 0.006 / STROKE_S < 2.0 * still
    assert stroke_values(TIMES_S, slow, WINDOWS_S, 0.002) == []
    assert len(stroke_values(TIMES_S, slow, WINDOWS_S, 0.0)) == STROKES


@pytest.mark.parametrize("rate_hz", [30.0, 60.0, 100.0, 1000.0])
def test_speed_of_noise_is_what_noise_makes(rate_hz: float) -> None:
    noise = np.random.default_rng(2).normal(0.0, 1.0, (20_000, 1))
    made = np.sqrt(np.mean(speed_m_s(low_pass(noise, rate_hz), rate_hz) ** 2))
    assert noise_speed_m_s(1.0, rate_hz) / NOISE_SPEEDS == pytest.approx(made, rel=0.06)
