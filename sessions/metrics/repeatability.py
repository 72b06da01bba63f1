"""How repeatable a number is: SEM and minimal detectable change from repeated measurements.

One-way repeated-measures analysis of variance: the same subjects are measured k times without a change
between; what is left within a subject is the error of measurement, SEM = sqrt(mean square within).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from sessions.metrics.metric import Z95, Estimate, Metric
from sessions.metrics.registry import definition

FEWEST = 5
"""Fewest degrees of freedom: with fewer the SEM itself is known only within a factor of three."""


@dataclass(frozen=True, slots=True)
class Repeat:
    """Repeatability of one number of one set-up.

    Attributes:
        name: Metric.
        subject: Joint, digit or "whole".
        source: What measured it.
        version: Version of the method.
        trials: Measurements that took part.
        subjects: Groups they belong to.
        sem: Standard error of measurement, SI units.
        sem_low: Lower end of its 95 % interval (chi-squared).
        sem_high: Upper end.
        mdc95: Minimal detectable change, SI units.
    """

    name: str
    subject: str
    source: str
    version: str
    trials: int
    subjects: int
    sem: float
    sem_low: float
    sem_high: float
    mdc95: float


def mdc95(sem: float) -> float:
    """What 95 % of the differences between two measurements without a change stay below: 1.96 sqrt(2) SEM."""
    return Z95 * math.sqrt(2.0) * sem


def standard_error(groups: Sequence[Sequence[float]]) -> Estimate:
    """SEM over subjects that were each measured at least twice; its interval is that of a variance.

    Args:
        groups: Measurements by subject; those that are not finite take no part.
    """
    known = [np.array([value for value in group if math.isfinite(value)]) for group in groups]
    known = [group for group in known if group.size >= 2]
    freedom = sum(group.size - 1 for group in known)
    if freedom < FEWEST:
        return Estimate.missing(f"{freedom} degrees of freedom: measure at least {FEWEST + 1} times")
    square = sum(float(((group - group.mean()) ** 2).sum()) for group in known)
    low, high = (math.sqrt(square / float(chdtri(freedom, share))) for share in (0.025, 0.975))
    return Estimate(math.sqrt(square / freedom), (low, high))


def repeatability(rows: Iterable[tuple[str, Iterable[Metric]]]) -> tuple[Repeat, ...]:
    """Repeatability of every number that was measured often enough.

    Args:
        rows: Whose measurement it was (subject and exercise), and its metrics.
    """
    grouped: dict[tuple[str, str, str, str], dict[str, list[float]]] = {}
    for whose, metrics in rows:
        for item in metrics:
            key = (item.name, item.subject, item.lineage.source, item.version)
            if item.measurable and not definition(item.name).exact:
                grouped.setdefault(key, {}).setdefault(whose, []).append(item.value)
    found: list[Repeat] = []
    for key, groups in sorted(grouped.items()):
        error = standard_error(list(groups.values()))
        if error.interval is None:
            continue
        used = [group for group in groups.values() if len(group) >= 2]
        trials = sum(len(group) for group in used)
        found.append(Repeat(*key, trials, len(used), error.value, *error.interval, mdc95(error.value)))
    return tuple(found)
