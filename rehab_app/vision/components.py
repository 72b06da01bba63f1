"""Connected parts of a sparse mask: joined from runs of pixels, so that empty image costs nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.records.fields import Int64


@dataclass(frozen=True, slots=True)
class Parts:
    """Pixels of the parts of a mask.

    Attributes:
        row: Row of each pixel, shape (P,).
        column: Column of each pixel, shape (P,).
        owner: Part of each pixel, counted from 0, shape (P,).
        count: Number of parts.
    """

    row: Int64
    column: Int64
    owner: Int64
    count: int

    def only(self, chosen: NDArray[np.bool_]) -> Parts:
        """The chosen parts alone, numbered anew in the same order; ``chosen`` has shape (count,)."""
        inside = chosen[self.owner]
        number = np.cumsum(chosen) - 1
        return Parts(self.row[inside], self.column[inside], number[self.owner[inside]], int(chosen.sum()))


def connected_parts(mask: NDArray[np.bool_]) -> Parts:
    """Parts of a mask (H, W) whose pixels touch along an edge or at a corner."""
    row, column = np.divmod(np.flatnonzero(mask), mask.shape[1])
    return joined_pixels(row, column)


def joined_pixels(row: Int64, column: Int64) -> Parts:
    """Parts of a set of pixels in the order of rows, then columns; shapes (P,)."""
    if not len(row):
        return Parts(row, column, row, 0)
    width = int(column.max()) + 3  # a gap behind each row keeps its last run from the next row's first
    key = row * width + column
    first = np.flatnonzero(np.diff(key, prepend=key[0] - 2) != 1)
    length = np.diff(first, append=len(key))
    begin, end = key[first], key[first] + length
    low = np.searchsorted(end, begin + width - 1, side="right")
    high = np.searchsorted(begin, end + width + 1, side="left")
    touched = np.maximum(high - low, 0)
    above = np.repeat(np.arange(len(first)), touched)
    below = np.arange(len(above)) - np.repeat(np.cumsum(touched) - touched, touched) + np.repeat(low, touched)
    label = _united(len(first), above, below)
    roots, part = np.unique(label, return_inverse=True)
    return Parts(row, column, np.repeat(part, length), len(roots))


def _united(count: int, one: Int64, other: Int64) -> Int64:
    """Smallest index that each of ``count`` things is linked to, however far; links are pairs of indices."""
    label = np.arange(count)
    while True:
        least = np.minimum(label[one], label[other])
        after = label.copy()
        for end in (label[one], label[other]):
            np.minimum.at(after, end, least)
        after = after[after]
        if np.array_equal(after, label):
            return label
        label = after
