"""One process at a time has a device; however that process ends, the next one may have it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from robot_iface.adapters.lease import Lease
from robot_iface.errors import Refused

NAME = f"lease-test-{os.getpid()}"
HOLD = """
import sys
from robot_iface.adapters.lease import Lease
lease = Lease(sys.argv[1])
print("held", flush=True)
sys.stdin.read()
"""


def test_a_second_holder_is_refused_until_the_first_gives_it_back() -> None:
    lease = Lease(NAME)
    with pytest.raises(Refused, match=f"device {NAME} is in use by another process"):
        Lease(NAME)
    Lease(f"{NAME}-other").release()
    lease.release()
    Lease(NAME).release()


def test_a_killed_holder_gives_it_back() -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, NAME], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(Refused, match="in use"):
            Lease(NAME)
        holder.kill()
        holder.wait()
    Lease(NAME).release()
