from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sessions.metrics.filtering import low_pass, speed_m_s
from sessions.metrics.smoothness import ldlj, sparc

T = np.arange(100) / 100
MINIMUM_JERK = 30 * T**2 * (1 - T) ** 2


def gaussian() -> np.ndarray:
    return np.exp(-5.0 * np.arange(-1, 1, 0.01) ** 2)


def two(gap_s: float) -> np.ndarray:
    return np.concatenate((MINIMUM_JERK, np.zeros(round(gap_s * 100)), MINIMUM_JERK))


@pytest.mark.parametrize(
    ("profile", "arc", "jerk", "digits"),
    [
        (gaussian(), -1.41403, -5.81636, 5),
        (MINIMUM_JERK, -1.40583, -5.22414, 5),
        (two(0.0), -2.2445, -8.046, 3),
        (two(0.5), -3.1190, -8.703, 3),
        (two(1.0), -3.9935, -9.250, 3),
    ],
)
def test_published_and_reference_values(profile: np.ndarray, arc: float, jerk: float, digits: int) -> None:
    assert sparc(profile, 100.0).value == pytest.approx(arc, abs=0.6 * 10**-digits if digits > 3 else 6e-5)
    assert ldlj(profile, 100.0).value == pytest.approx(jerk, abs=0.6 * 10**-digits)


def test_sampling_that_includes_the_last_sample() -> None:
    t = np.linspace(0.0, 1.0, 100)
    profile = 30 * t**2 * (1 - t) ** 2
    assert sparc(profile, 100.0).value == pytest.approx(-1.4013, abs=1e-4)
    assert ldlj(profile, 100.0).value == pytest.approx(-5.3018, abs=1e-4)


def test_ldlj_of_a_finely_sampled_minimum_jerk_is_the_exact_one() -> None:
    t = np.arange(20000) / 20000
    assert ldlj(30 * t**2 * (1 - t) ** 2, 20000.0).value == pytest.approx(-math.log(204.8), abs=1e-3)


@settings(max_examples=40, deadline=None)
@given(st.floats(1e-6, 1e6))
def test_amplitude_does_not_matter(scale: float) -> None:
    assert sparc(scale * two(0.5), 100.0).value == pytest.approx(sparc(two(0.5), 100.0).value, rel=1e-9)
    assert ldlj(scale * two(0.5), 100.0).value == pytest.approx(ldlj(two(0.5), 100.0).value, rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.6, 4.0))
def test_duration_does_not_matter_to_sparc(duration_s: float) -> None:
    t = np.arange(round(200 * duration_s)) / (200 * duration_s)
    assert sparc(30 * t**2 * (1 - t) ** 2, 200.0).value == pytest.approx(-1.40, abs=0.01)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.05, 1.0), st.floats(0.1, 1.0))
def test_a_longer_pause_is_less_smooth(gap_s: float, more_s: float) -> None:
    assert sparc(two(gap_s + more_s), 100.0).value < sparc(two(gap_s), 100.0).value
    assert ldlj(two(gap_s + more_s), 100.0).value < ldlj(two(gap_s), 100.0).value


@pytest.mark.parametrize(
    ("profile", "reason"),
    [
        (np.zeros(50), "nothing moved"),
        (np.ones(3), "fewer than 8"),
        (np.array([1.0] * 20 + [np.nan] * 5), "gap"),
    ],
)
def test_what_cannot_be_measured_says_why(profile: np.ndarray, reason: str) -> None:
    for family in (sparc, ldlj):
        estimate = family(profile, 100.0)
        assert math.isnan(estimate.value)
        assert reason in estimate.reason


def test_noise_floor_of_an_unfiltered_stroke_and_what_the_filter_buys() -> None:
    rng, rate = np.random.default_rng(3), 30.0
    tau = np.arange(31) / 30
    raw, filtered = [], []
    for _ in range(50):
        p = rng.normal(0.0, 0.001, (31, 3))
        p[:, 0] += 0.08 * (10 * tau**3 - 15 * tau**4 + 6 * tau**5)
        raw.append([f(speed_m_s(p, rate), rate).value for f in (sparc, ldlj)])
        filtered.append([f(speed_m_s(low_pass(p, rate), rate), rate).value for f in (sparc, ldlj)])
    raw_mean, filtered_mean = np.mean(raw, axis=0), np.mean(filtered, axis=0)
    assert raw_mean[0] < -1.6
    assert raw_mean[1] < -8.0
    assert filtered_mean[0] > raw_mean[0] + 0.1
    assert filtered_mean[1] > raw_mean[1] + 1.0


def test_the_filter_halves_power_at_six_hertz_and_delays_nothing() -> None:
    rate, t = 200.0, np.arange(4000) / 200.0
    kept = low_pass(np.sin(2 * np.pi * 6.0 * t), rate)[1000:3000]
    assert float(np.sqrt(2 * np.mean(kept**2))) == pytest.approx(math.sqrt(0.5), abs=0.01)
    slow = np.sin(2 * np.pi * 0.5 * t)
    assert float(np.abs(low_pass(slow, rate) - slow)[200:-200].max()) < 1e-3
