"""One way to compile the numeric heart of a control tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """A function of numbers and arrays as machine code, compiled at its first call and kept on disk.

    Division by zero gives infinities, as in numpy; nothing is reordered, so that results are the same bits
    wherever they are computed. ``NUMBA_DISABLE_JIT=1`` leaves it interpreted (for mutation tests).
    """
    library: Any = numba
    try:
        return library.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # no folder may be written: then it is compiled anew in each process
        return library.njit(error_model="numpy")(function)
