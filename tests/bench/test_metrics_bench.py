"""Smoothness of a thousand movements, and how often intervals hold the truth: printed, ratios asserted."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from sessions.metrics.honest import SHARES
from sessions.metrics.smoothness import sparc_many
from sessions.metrics.stroke_noise import NOISE_TAILS
from tests.bench.interval_coverage import covered

pytestmark = pytest.mark.bench

MOVEMENTS, RATE_HZ = 1000, 100.0
HELD_OUT = range(301, 309)
STROKES_HELD_OUT, STROKES_S = range(311, 313), 24.0  # three strokes at least make an interval
MOVES = ("open_close", "index_pip", "tapping", "pinch")


def say(text: str) -> None:
    sys.stdout.write(text + "\n")


def published(speed: np.ndarray, rate_hz: float) -> float:
    """The formula step by step, one movement at a time, as the authors describe it."""
    size = int(2 ** (np.ceil(np.log2(len(speed))) + 4))
    frequency = np.arange(0, rate_hz, rate_hz / size)
    spectrum = np.abs(np.fft.fft(speed, size))
    spectrum = spectrum / np.max(spectrum)
    below = np.nonzero((frequency <= 10.0) * 1)[0]
    frequency, spectrum = frequency[below], spectrum[below]
    above = np.nonzero((spectrum >= 0.05) * 1)[0]
    chosen = range(above[0], above[-1] + 1)
    frequency, spectrum = frequency[chosen], spectrum[chosen]
    steps = np.diff(frequency) / (frequency[-1] - frequency[0])
    return float(-np.sum(np.sqrt(steps**2 + np.diff(spectrum) ** 2)))


def profiles() -> list[np.ndarray]:
    rng = np.random.default_rng(1)
    found: list[np.ndarray] = []
    for length in rng.integers(80, 160, MOVEMENTS):
        t = np.arange(length) / length
        found.append(30 * t**2 * (1 - t) ** 2 + 0.02 * np.abs(rng.normal(size=length)))
    return found


def quickest(work: Callable[[], Sequence[float]]) -> tuple[float, Sequence[float]]:
    best, made = float("inf"), list[float]()
    for _ in range(5):
        start = time.process_time()
        made = list(work())
        best = min(best, time.process_time() - start)
    return best, made


def test_a_thousand_movements() -> None:
    speeds = profiles()
    slow, one_by_one = quickest(lambda: [published(speed, RATE_HZ) for speed in speeds])
    fast, together = quickest(lambda: [found.value for found in sparc_many(speeds, RATE_HZ)])
    np.testing.assert_allclose(together, one_by_one, atol=1e-9, rtol=0)
    say(f"SPARC of {MOVEMENTS}: loop {1e3 * slow:.0f} ms, together {1e3 * fast:.0f} ms, {slow / fast:.1f} x")
    assert slow / fast >= 5.0


def test_intervals_hold_the_truth_on_seeds_that_tuned_nothing(tmp_path: Path) -> None:
    counts = covered(tmp_path, MOVES, HELD_OUT)
    for name, row in counts.items():
        say(row.words(name))
    held, number = (sum(getattr(row, name) for row in counts.values()) for name in ("held", "number"))
    say(f"all: {100 * held / number:.1f} % of {number}")
    assert set(counts) == set(SHARES)
    assert 0.90 <= held / number <= 0.98


def test_intervals_of_strokes_hold_the_truth_on_seeds_that_tuned_nothing(tmp_path: Path) -> None:
    counts = covered(tmp_path, MOVES, STROKES_HELD_OUT, tuple(NOISE_TAILS), STROKES_S)
    for name, row in counts.items():
        say(row.words(name))
    assert all(row.number >= 10 for row in counts.values())
    held, number = (sum(getattr(row, name) for row in counts.values()) for name in ("held", "number"))
    say(f"all: {100 * held / number:.1f} % of {number}")
    assert held / number >= 0.90
