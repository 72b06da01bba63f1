"""What is usual among the patients of a clinic: groups of patients, and how a number is spread in each."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import astuple, dataclass
from datetime import date

import numpy as np

FEWEST = 5
"""A group of fewer patients is not told: a number could be anybody's."""
_DECADE = 10
_LOW, _HIGH = 5.0, 95.0


@dataclass(frozen=True, slots=True, order=True)
class Group:
    """Which patients are alike, and which number of theirs.

    Attributes:
        metric: Name of the metric.
        subject: Joint, digit or "whole".
        source: What measured it.
        mode: Therapy mode of the session.
        age_from: First year of age of the decade, at the session.
        side: Side of the hand.
        diagnosis: Key of the diagnosis template that held then, empty where none was stated.
    """

    metric: str
    subject: str
    source: str
    mode: str
    age_from: int
    side: str
    diagnosis: str


@dataclass(frozen=True, slots=True)
class Sample:
    """One number of one patient's session; SI units."""

    group: Group
    patient: str
    utc_ns: int
    value: float


@dataclass(frozen=True, slots=True)
class Norm:
    """How a number is spread over the patients of a group; SI units.

    Attributes:
        group: Which patients and which number.
        count: How many patients, at least ``FEWEST``.
        mean: Mean.
        sd: Standard deviation of the sample.
        median: Median.
        low: 5th percentile.
        high: 95th percentile.
    """

    group: Group
    count: int
    mean: float
    sd: float
    median: float
    low: float
    high: float


def norms_of(samples: Iterable[Sample]) -> tuple[Norm, ...]:
    """The spread within each group that has enough patients, sorted.

    Each patient counts once in a group, with the first session that has the number: therapy changes the later
    ones, and whoever comes often must not weigh more.

    Args:
        samples: In any order; it does not matter.
    """
    first: dict[Group, dict[str, tuple[int, float]]] = defaultdict(dict)
    for sample in samples:
        known = first[sample.group].get(sample.patient)
        found = (sample.utc_ns, sample.value)
        if known is None or found < known:
            first[sample.group][sample.patient] = found
    told = (group for group in first if len(first[group]) >= FEWEST)
    return tuple(
        _norm(group, [value for _, value in first[group].values()]) for group in sorted(told, key=astuple)
    )


def age_band(birth_date: str, day: date) -> int | None:
    """First year of age of the decade on a day, None where the birth date is unknown or after it.

    Args:
        birth_date: ISO date, may be empty.
        day: Date of the session.
    """
    if not birth_date:
        return None
    born = date.fromisoformat(birth_date)
    years = day.year - born.year - ((day.month, day.day) < (born.month, born.day))
    return None if years < 0 else years // _DECADE * _DECADE


def in_words(norm: Norm) -> str:
    """Where the norm comes from, as a report cites it: "n = 12, this clinic, age 60-69"."""
    begin = norm.group.age_from
    return f"n = {norm.count}, this clinic, age {begin}-{begin + _DECADE - 1}"


def _norm(group: Group, values: list[float]) -> Norm:
    sample = np.sort(np.asarray(values))
    low, median, high = (float(np.percentile(sample, share)) for share in (_LOW, 50.0, _HIGH))
    return Norm(group, len(sample), float(sample.mean()), float(sample.std(ddof=1)), median, low, high)
