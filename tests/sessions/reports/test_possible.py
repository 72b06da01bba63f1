"""No interval passes through values that a number cannot have; a number whose interval was cut says so."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.metrics import DEFINITIONS, Estimate, Lineage, Metric
from sessions.metrics.metric import metric
from sessions.reports.possible import CUT, ENDS, within_ends
from sessions.reports.wording import interval

LINEAGE = Lineage("a1" * 32, (), 0, 0, "encoder")


def made(name: str, value: float, low: float, high: float, flag: str = "") -> Metric:
    return metric(name, "index", Estimate(value, (low, high)), LINEAGE, flag)


@given(st.sampled_from(sorted(ENDS)), st.floats(-20.0, 20.0), st.floats(0.0, 30.0))
def test_the_interval_holds_the_value_and_nothing_impossible(name: str, value: float, half: float) -> None:
    least, most = ENDS[name]
    value = min(max(value, least), most)
    item = within_ends(made(name, value, value - half, value + half))
    assert item.interval is not None
    low, high = item.interval
    assert least <= low <= value <= high <= most
    assert (CUT in item.status) == ((low, high) != (value - half, value + half))
    assert within_ends(item) == item


def test_a_cut_keeps_what_was_said_before() -> None:
    item = within_ends(made("sparc", -7.8, -19.8, 4.2, "reliability is known for arms"))
    assert item.interval == (-19.8, 0.0)
    assert item.status == f"flagged: {CUT}; reliability is known for arms"


def test_numbers_with_a_sign_are_left_alone() -> None:
    item = made("angle_min", -0.1, -0.3, 0.1)
    assert within_ends(item) is item


def test_every_end_is_of_a_known_number() -> None:
    assert set(ENDS) <= set(DEFINITIONS)


@pytest.mark.parametrize(("half", "shown"), [(0.0001, ""), (0.01, "56.7 to 57.9")])
def test_an_interval_that_reads_as_the_value_is_not_printed(half: float, shown: Any) -> None:
    assert interval(made("range_of_motion", 1.0, 1.0 - half, 1.0 + half)) == shown
    assert math.isfinite(half)
