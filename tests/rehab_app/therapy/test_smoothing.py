from __future__ import annotations

import numpy as np
import pytest

from rehab_app.therapy.smoothing import smooth, within

T_S = np.arange(0.0, 6.0, 0.01)
GRID_S = np.linspace(0.0, T_S[-1], 301)
STD = np.full(T_S.size, np.deg2rad(2.0))


def sine(t_s: np.ndarray) -> np.ndarray:
    """Starts and ends at rest: half a radian up and down every 2 s."""
    return 0.25 * (1 - np.cos(np.pi * t_s))


def test_a_noisy_sine_is_recovered_better_than_its_samples() -> None:
    noise = STD * np.random.default_rng(1).standard_normal(T_S.size)
    path = smooth(T_S, sine(T_S) + noise, STD, GRID_S, 20.0)
    error = np.sqrt(np.mean((path - sine(GRID_S))[20:-20] ** 2))
    assert error < np.deg2rad(0.6)
    jerk = np.diff(path, 3) / (GRID_S[1] - GRID_S[0]) ** 3
    assert np.sqrt(np.mean(jerk[20:-20] ** 2)) < 3 * 0.25 * np.pi**3


def test_both_ends_are_at_rest() -> None:
    path = smooth(T_S, np.sin(T_S), STD, GRID_S, 20.0)
    step_s = GRID_S[1] - GRID_S[0]
    assert abs(path[1] - path[0]) / step_s < 0.005
    assert abs(path[-1] - path[-2]) / step_s < 0.01


def test_a_swapped_marker_does_not_pull() -> None:
    samples = sine(T_S)
    samples[200:215] += 1.0
    path = smooth(T_S, samples, STD, GRID_S, 20.0)
    assert np.abs(path - sine(GRID_S))[20:-20].max() < np.deg2rad(6)


def test_a_gap_is_bridged_by_a_smooth_curve() -> None:
    samples = sine(T_S)
    samples[280:330] = np.nan
    path = smooth(T_S, samples, STD, GRID_S, 20.0)
    assert np.abs(path - sine(GRID_S))[20:-20].max() < np.deg2rad(4)


def test_a_long_gap_does_not_run_away() -> None:
    samples = sine(T_S)
    samples[150:550] = np.nan
    path = smooth(T_S, samples, STD, GRID_S, 20.0)
    assert -0.3 < path.min() < path.max() < 1.0


def test_the_certain_sample_wins() -> None:
    std = np.where(np.arange(T_S.size) % 2, 0.01, 0.5)
    samples = np.where(np.arange(T_S.size) % 2, sine(T_S), sine(T_S) + 0.4)
    path = smooth(T_S, samples, std, GRID_S, 20.0)
    assert np.abs(path - sine(GRID_S))[20:-20].max() < np.deg2rad(1)


def test_uneven_samples_on_a_finer_grid() -> None:
    t_s = np.sort(np.random.default_rng(2).uniform(0, 6, 180))
    t_s[0], t_s[-1] = 0.0, T_S[-1]
    path = smooth(t_s, sine(t_s), np.full(180, 0.01), GRID_S, 20.0)
    assert np.abs(path - sine(GRID_S))[20:-20].max() < np.deg2rad(1)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.5), (-0.2, 0.4), (0.1, 0.12)])
def test_a_bounded_path_is_strictly_inside_and_smooth(low: float, high: float) -> None:
    wish = np.linspace(-3, 3, 6001)
    path = within(wish, low, high)
    assert low < path.min()
    assert path.max() < high
    assert (np.diff(path) >= 0).all()
    assert np.abs(np.diff(path, 2)).max() / 0.001**2 < 2 / min(np.deg2rad(1.0), (high - low) / 12)


def test_the_middle_of_the_range_is_left_alone() -> None:
    wish = np.linspace(np.deg2rad(6), np.deg2rad(84), 50)
    np.testing.assert_allclose(within(wish, 0.0, np.deg2rad(90)), wish, atol=np.deg2rad(0.02))
