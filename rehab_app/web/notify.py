"""Tells systemd how the server is: one datagram to the socket that it named; without one nothing is told."""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Mapping

READY, STOPPING, ALIVE = "READY=1", "STOPPING=1", "WATCHDOG=1"
_SOCKET, _PERIOD, _PROCESS = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"


def notify(state: str, environment: Mapping[str, str] | None = None) -> bool:
    """Tell the service manager; whether it was told.

    Args:
        state: ``READY``, ``STOPPING`` or ``ALIVE``.
        environment: Variables; by default those of the process.
    """
    variables = os.environ if environment is None else environment
    address = variables.get(_SOCKET, "")
    if not address.startswith(("/", "@")):
        return False
    if address.startswith("@"):  # an abstract name
        address = "\0" + address[1:]
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line:
        line.setblocking(False)
        line.sendto(state.encode(), address)
        return True
    return False


def watchdog_s(environment: Mapping[str, str] | None = None) -> float:
    """How often to give the sign of life: half of the time that the service manager waits; 0 for never."""
    variables = os.environ if environment is None else environment
    try:
        period_us, process = int(variables.get(_PERIOD, "0")), variables.get(_PROCESS, "")
    except ValueError:
        return 0.0
    meant = process in ("", str(os.getpid()))
    return max(0, period_us) / 2e6 if meant else 0.0
