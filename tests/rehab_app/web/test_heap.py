"""What a server's threads needed goes back to the system; measured in a process of its own."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys

import pytest

from rehab_app.web.heap import keep_heap_small

PROGRAM = """
import ctypes, sys, threading
from rehab_app.web.heap import keep_heap_small
if sys.argv[1] == "small":
    assert keep_heap_small()
kept, gate = [], threading.Barrier(16)
def session():
    gate.wait()
    blocks = [bytearray(100_000) for _ in range(200)]
    kept.append(blocks[100])
threads = [threading.Thread(target=session) for _ in range(16)]
for thread in threads: thread.start()
for thread in threads: thread.join()
libc = ctypes.CDLL(None)
libc.malloc_info(0, ctypes.c_void_p.in_dll(libc, "stdout"))
libc.fflush(None)
"""


def arenas(how: str) -> int:
    """How many arenas of the C library a process has after sixteen sessions at once."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MALLOC_")}
    ran = subprocess.run(
        [sys.executable, "-c", PROGRAM, how], capture_output=True, text=True, check=True, env=environment
    )
    return ran.stdout.count("<heap nr=")


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "malloc_info"), reason="only glibc has arenas")
def test_threads_share_two_arenas() -> None:
    assert arenas("left alone") > 2
    assert arenas("small") <= 2


def test_who_set_the_environment_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MALLOC_ARENA_MAX", "4")
    assert not keep_heap_small()
