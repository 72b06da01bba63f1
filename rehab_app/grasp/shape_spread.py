"""Mean and standard deviation over repetitions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sessions.records.fields import Float64, Int64


@dataclass(frozen=True, slots=True)
class Spread:
    """What repetitions have in common; arrays of the shape of one repetition.

    Attributes:
        mean: Mean over the repetitions in which the value is finite, NaN where there is none.
        sd: Standard deviation with n - 1, NaN below two.
        count: In how many it is finite.
    """

    mean: Float64
    sd: Float64
    count: Int64


def spread(values: Float64) -> Spread:
    """Mean and standard deviation over the first axis; what is not finite does not count.

    Args:
        values: One row a repetition, shape (R, ...).
    """
    finite = np.isfinite(values)
    count: Int64 = finite.sum(axis=0, dtype=np.int64)
    total = np.where(finite, values, 0.0).sum(axis=0)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    off = np.where(finite, values - np.where(count > 0, mean, 0.0), 0.0)
    variance = (np.where(finite, off, 0.0) ** 2).sum(axis=0) / np.maximum(count - 1, 1)
    return Spread(mean, np.where(count > 1, np.sqrt(variance), np.nan), count)
