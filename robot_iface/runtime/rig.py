"""What a run is given: device, clock and patient on one side, people and listeners on the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from robot_iface.ports import Clock, EmergencyStop, HandRobot
from robot_iface.runtime.live import Monitor, Unwatched
from robot_iface.runtime.orders import Inbox, Patient
from robot_iface.runtime.record import Sink


class LoopClock(Clock, Protocol):
    """A clock that also knows how well it was kept."""

    @property
    def overruns(self) -> int:
        """Ticks that missed their deadline."""
        ...

    @property
    def overruns_in_row(self) -> int:
        """The same, consecutively, up to now."""
        ...

    @property
    def scheduling(self) -> str:
        """What scheduling the loop has, as a phrase."""
        ...

    def late_ns(self, percentile: float) -> int:
        """Lateness at a percentile of all ticks."""
        ...


@dataclass(frozen=True, slots=True)
class Rig:
    """What a run moves, by which time, with whom.

    Attributes:
        robot: The device; only the supervisor will write to it.
        clock: Time of the loop.
        patient: The patient's side.
    """

    robot: HandRobot
    clock: LoopClock
    patient: Patient


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a run hears and to whom it speaks.

    Attributes:
        stop: The stop that a person presses.
        sink: Receives every message, in order, the RunEnd last.
        inbox: Orders while it runs.
        monitor: Signs of life in, telemetry out.
        begun: Called once when the certificate is accepted, before the device is opened.
    """

    stop: EmergencyStop
    sink: Sink
    inbox: Inbox
    monitor: Monitor = field(default_factory=Unwatched)
    begun: Callable[[], None] = lambda: None


class ScheduledStop:
    """The person's stop, pressed also at the times that a plan scripts.

    Args:
        stop: What a person presses.
        clock: Time of the loop.
        at_s: Times since now, s.
    """

    def __init__(self, stop: EmergencyStop, clock: Clock, at_s: tuple[float, ...]) -> None:
        self._stop = stop
        self._clock = clock
        self._at_ns = clock.now_ns() + round(min(at_s) * 1e9) if at_s else None

    def pressed(self) -> bool:
        """Whether stop is pressed."""
        if self._stop.pressed():
            return True
        return self._at_ns is not None and self._clock.now_ns() >= self._at_ns
