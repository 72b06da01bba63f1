"""Repetitions of recordings, and two recordings laid over each other repetition by repetition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rehab_app.services.replay_repetitions import of_movement
from rehab_app.web.viewport.second import aligned

NOTHING = np.empty((0, 2))


def hand(repetitions, period_s=2.0):
    t_s = np.arange(0.0, repetitions * period_s + 1.0, 0.02)
    closed = np.where(t_s <= repetitions * period_s, 0.5 - 0.5 * np.cos(2 * np.pi * t_s / period_s), 0.0)
    joints = np.zeros((t_s.size, 21))
    joints[:, [4, 6, 8, 10]] = closed[:, None]
    return t_s, joints


@pytest.mark.parametrize("repetitions", [1, 3, 7])
def test_every_closing_and_opening_is_one_repetition(repetitions):
    found = of_movement(*hand(repetitions))
    assert len(found) == repetitions
    assert found[:, 0] == pytest.approx(2.0 * np.arange(repetitions), abs=0.35)
    assert np.all(found[:, 1] > found[:, 0])


def test_a_hand_at_rest_repeats_nothing():
    t_s, joints = hand(1)
    assert of_movement(t_s, 0.0 * joints).shape == (0, 2)
    assert of_movement(t_s[:1], joints[:1]).shape == (0, 2)


spans = st.lists(st.floats(0.2, 5.0), min_size=2, max_size=12).map(
    lambda steps: np.cumsum(steps)[: len(steps) // 2 * 2].reshape(-1, 2)
)


@given(first=spans, second=spans)
def test_the_same_part_of_the_same_repetition_lies_together(first, second):
    count = min(len(first), len(second))
    for part in (0.0, 0.25, 1.0):
        at_s = first[:count, 0] + part * (first[:count, 1] - first[:count, 0])
        there_s = second[:count, 0] + part * (second[:count, 1] - second[:count, 0])
        assert aligned(first, second, at_s) == pytest.approx(there_s, abs=1e-9)


@given(first=spans, second=spans)
def test_time_never_runs_backwards(first, second):
    at_s = np.linspace(-5.0, first[-1, 1] + 5.0, 200)
    assert np.all(np.diff(aligned(first, second, at_s)) >= -1e-9)


def test_a_recording_is_aligned_with_itself_and_without_repetitions_by_time():
    spans_s = np.array([[1.0, 2.0], [3.0, 5.0]])
    at_s = np.linspace(0.0, 8.0, 81)
    assert aligned(spans_s, spans_s, at_s) == pytest.approx(at_s)
    assert aligned(spans_s, NOTHING, at_s) == pytest.approx(at_s)
