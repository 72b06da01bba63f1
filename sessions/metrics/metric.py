"""What one reported number is: value, unit, uncertainty, method version, status and lineage."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sessions.metrics.registry import definition

Interval = tuple[float, float]
NO_INTERVAL = "no interval"
"""How every remark begins that says why a value has none."""
Z95 = 1.959963984540054
"""Two-sided 95 % point of the normal distribution; every interval of this package is a 95 % interval."""


@dataclass(frozen=True, slots=True)
class Lineage:
    """Where a number comes from, so that anybody can make it again.

    Attributes:
        file_sha256: SHA-256 of the file, hexadecimal.
        topics: Names of the topics that were read.
        t_start_ns: First monotonic time that took part.
        t_end_ns: Last monotonic time that took part.
        source: What measured it, such as "encoder" or "virtual-camera".
        conditions: Under which conditions it holds (stiffness, filter), empty if none.
    """

    file_sha256: str
    topics: tuple[str, ...]
    t_start_ns: int
    t_end_ns: int
    source: str
    conditions: str = ""


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a pure metric function returns.

    Attributes:
        value: The number in SI units, NaN where it cannot be had.
        interval: Its 95 % interval, None where no honest one exists.
        reason: Why the value is NaN; or, beside a finite value, what must be said of it; empty if nothing.
    """

    value: float
    interval: Interval | None = None
    reason: str = ""

    @classmethod
    def missing(cls, reason: str) -> Estimate:
        """No value, and why."""
        return cls(math.nan, None, reason)


@dataclass(frozen=True, slots=True)
class Metric:
    """One number of a report.

    Attributes:
        name: Name in the registry, such as "fingertip_rmse".
        subject: Joint, digit, marker or "whole".
        value: The number in ``unit``; NaN exactly when the status says "not measurable".
        unit: SI unit, "1" for what has none.
        interval: 95 % interval, None where no honest one exists.
        version: Version of the method.
        status: "ok", "flagged: ..." or "not measurable: ...".
        lineage: Where the number comes from.
    """

    name: str
    subject: str
    value: float
    unit: str
    interval: Interval | None
    version: str
    status: str
    lineage: Lineage

    @property
    def measurable(self) -> bool:
        """Whether there is a value."""
        return math.isfinite(self.value)


def metric(name: str, subject: str, estimate: Estimate, lineage: Lineage, flag: str = "") -> Metric:
    """Give an estimate its name, unit, version and status.

    Args:
        name: A name of the registry.
        subject: Joint, digit, marker or "whole".
        estimate: What was computed.
        lineage: Where from.
        flag: What a reader must be told beside a value, empty if nothing.

    Raises:
        KeyError: The registry does not hold that name.
    """
    known = definition(name)
    remark = "; ".join(text for text in (estimate.reason, flag) if text)
    if not math.isfinite(estimate.value):
        status = f"not measurable: {estimate.reason or 'the value is not finite'}"
        return Metric(name, subject, math.nan, known.unit, None, known.version, status, lineage)
    interval = _finite(estimate.interval)
    if interval is None and not known.exact and NO_INTERVAL not in remark:
        remark = "; ".join(text for text in (remark, f"{NO_INTERVAL}: the error is not stated") if text)
    return Metric(
        name,
        subject,
        float(estimate.value),
        known.unit,
        interval,
        known.version,
        f"flagged: {remark}" if remark else "ok",
        lineage,
    )


def _finite(interval: Interval | None) -> Interval | None:
    if interval is None or not all(math.isfinite(end) for end in interval):
        return None
    return (float(interval[0]), float(interval[1]))
