"""The heap of a server that runs for days: what a session needed goes back to the system when it is over.

Left alone, the C library keeps an arena for every thread or two and, once a large block was freed, takes
blocks up to that size from them: after hours of sessions half of the heap was holes, and the process grew by
a tenth (``docs/benchmarks.md``).
"""

from __future__ import annotations

import ctypes
import os
from contextlib import suppress

_ARENAS, _OWN_MAPPING_BYTES, _TRIM_BYTES = 2, 256 * 1024, 1024 * 1024
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8
_OWN_WORD = "MALLOC_ARENA_MAX"
"""Who sets this one in the environment has an opinion of their own."""


def keep_heap_small() -> bool:
    """Two arenas, and large blocks always apart; whether this C library (glibc) could be told so.

    Call it before threads begin.
    """
    if _OWN_WORD in os.environ:
        return False
    with suppress(OSError, AttributeError):
        mallopt = ctypes.CDLL(None).mallopt
        wanted = (
            (_M_ARENA_MAX, _ARENAS),
            (_M_MMAP_THRESHOLD, _OWN_MAPPING_BYTES),
            (_M_TRIM_THRESHOLD, _TRIM_BYTES),
        )
        return all([bool(mallopt(word, value)) for word, value in wanted])
    return False
