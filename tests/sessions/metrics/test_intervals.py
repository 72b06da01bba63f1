"""Intervals hold the virtual camera's truth; every number has one or says why not. Long run: tests/bench."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from sessions.metrics import Metric, definition, measure
from tests.bench.interval_coverage import covered

Make = Callable[..., Any]


def test_intervals_hold_the_truth_on_a_seed_that_tuned_nothing(tmp_path: Path) -> None:
    counts = covered(tmp_path, ("open_close",), (109,))
    held, number = (sum(getattr(row, name) for row in counts.values()) for name in ("held", "number"))
    assert number > 60
    assert held / number >= 0.85


def silent(item: Metric) -> bool:
    exact = definition(item.name).exact
    return item.measurable and item.interval is None and not exact and "interval" not in item.status


def test_every_number_has_an_interval_or_says_why_not(make_take: Make, make_session: Make) -> None:
    for summary in (measure(make_take()), measure(make_session()), measure(make_take(repetitions=1))):
        assert [(item.name, item.subject) for item in summary.metrics if silent(item)] == []
        assert all(item.measurable or item.status.startswith("not measurable: ") for item in summary.metrics)


def test_a_clock_that_jumps_gives_gaps_and_no_numbers_from_nothing(
    make_take: Make, make_session: Make
) -> None:
    for recording in (make_take(), make_session()):
        for rows in recording.topics.values():
            t_ns = rows["t_ns"]
            if len(t_ns) > 200:
                t_ns[len(t_ns) // 3 :] += 3_600_000_000_000
                t_ns[2 * len(t_ns) // 3 :] -= 7_200_000_000_000
        summary = measure(recording)
        assert [(item.name, item.subject) for item in summary.metrics if silent(item)] == []


def test_a_hand_that_was_only_estimated_has_no_unflagged_range(make_take: Make) -> None:
    take = make_take()
    take.topics["/hand/pose"]["joint_status"][:] = 1
    summary = measure(take)
    assert all(item.status.startswith("flagged: estimated") for item in summary.named("range_of_motion"))
    assert not any(item.measurable for item in summary.named("total_active_motion"))
