"""Reference values that stand in no other test: minimum jerk in closed form, unfiltered noise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sessions.metrics.smoothness import ldlj, ldlj_many, sparc


def test_minimum_jerk_in_closed_form() -> None:
    """Amplitude 0.08 m in 1.6 s: largest acceleration 5.7735 A/T^2, squared jerk integrates to 720."""
    amplitude, duration, rate = 0.08, 1.6, 50_000.0
    tau = np.arange(round(duration * rate)) / (duration * rate)
    speed = amplitude / duration * 30 * tau**2 * (1 - tau) ** 2
    acceleration = np.gradient(speed, 1.0 / rate)
    assert acceleration.max() * duration**2 / amplitude == pytest.approx(5.7735, abs=1e-4)
    cost = math.exp(-ldlj(speed, rate).value)
    assert cost * (speed.max() * duration / amplitude) ** 2 == pytest.approx(720.0, rel=1e-3)
    assert speed.max() * duration / amplitude == pytest.approx(1.875, abs=1e-6)


def test_unfiltered_noise_drowns_smoothness() -> None:
    """80 mm in one second at 30 Hz with 1 mm of noise, unfiltered: -1.94 and -10.9, not -1.41 and -5.2."""
    rng = np.random.default_rng(2)
    tau = np.linspace(0.0, 1.0, 31)
    path = 0.08 * (10 * tau**3 - 15 * tau**4 + 6 * tau**5)
    arcs, jerks = list[float](), list[float]()
    for _ in range(400):
        speed = np.abs(np.gradient(path + rng.normal(0.0, 0.001, tau.size), 1 / 30))
        arcs.append(sparc(speed, 30.0).value)
        jerks.append(ldlj(speed, 30.0).value)
    assert np.mean(arcs) == pytest.approx(-1.94, abs=0.015)
    assert np.mean(jerks) == pytest.approx(-10.9, abs=0.05)


def test_many_profiles_together_give_what_each_gives_alone() -> None:
    """The formula step by step, one movement at a time, against the batch: 1e-9."""
    rng = np.random.default_rng(4)
    profiles = [np.abs(rng.normal(1.0, 0.3, rng.integers(1, 90))) for _ in range(60)]
    profiles += [np.zeros(20), np.full(20, 0.3), np.r_[np.ones(9), np.nan], np.array([])]
    together = ldlj_many(profiles, 120.0)
    for speed, found in zip(profiles, together, strict=True):
        if speed.size < 8:
            assert "fewer than 8" in found.reason
        elif not np.isfinite(speed).all():
            assert "gap" in found.reason
        elif not speed.max() > 0.0:
            assert "nothing moved" in found.reason
        elif np.ptp(speed) == 0.0:
            assert "does not change" in found.reason
        else:
            jerk = np.diff(speed, 2) * 120.0**2
            cost = (speed.size / 120.0) ** 3 / speed.max() ** 2 * np.sum(jerk**2) / 120.0
            assert found.value == pytest.approx(-math.log(cost), abs=1e-9)
