"""Hazard: two programs move one device, and what one holds back the other pushes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from robot_iface.adapters.lease import Lease
from robot_iface.errors import Refused

NAME = f"two-masters-{os.getpid()}"
TAKE = """
import sys
from robot_iface.adapters.lease import Lease
from robot_iface.errors import Refused
try:
    Lease(sys.argv[1])
except Refused as refused:
    sys.exit(str(refused))
"""


def test_a_device_that_one_process_moves_is_refused_to_every_other() -> None:
    lease = Lease(NAME)
    with pytest.raises(Refused, match="in use by another process"):
        Lease(NAME)
    other = [sys.executable, "-c", TAKE, NAME]
    refused = subprocess.run(other, capture_output=True, text=True, check=False)
    assert refused.returncode == 1
    assert refused.stderr.startswith(f"device {NAME} is in use by another process, but must be free")
    lease.release()
    assert subprocess.run(other, check=False).returncode == 0
