"""The way out of a control loop, also of one that an error has cut short."""

from __future__ import annotations

from collections.abc import Callable

from robot_iface.safety.supervisor import Supervisor
from robot_iface.safety.watch import Watch
from robot_iface.safety.yielding import nothing


def brake_and_close(supervisor: Supervisor, next_tick: Callable[[], int]) -> None:
    """Close the device; where it still has power, by a category 1 stop first: a held-open hand would snap.

    Takes as long as that stop, at most 5 s of the loop's time. Every check goes on meanwhile, and whatever
    fails on the way (device, clock, the supervisor itself, a second interrupt) cuts power at once.

    Args:
        supervisor: Of the run that ends.
        next_tick: Waits for the next tick of the loop and returns its time, ns.
    """
    try:
        if supervisor.powered:
            supervisor.request_stop("run-broken-off")
        while supervisor.powered:
            state = supervisor.read(next_tick())
            supervisor.write(nothing(state.q_rad.size, 0), Watch())
    finally:
        supervisor.close()
