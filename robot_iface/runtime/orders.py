"""What a person may order while a run goes on, and what a run needs from the patient's side."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from robot_iface.errors import Refused
from robot_iface.types import Float64


@dataclass(frozen=True, slots=True)
class Pause:
    """Come to rest on the path."""


@dataclass(frozen=True, slots=True)
class Resume:
    """Go on along the path; after a hold and its reset, this is the new enable edge."""


@dataclass(frozen=True, slots=True)
class Reverse:
    """Go back along the path, to its start at most; ``Resume`` goes on again."""


@dataclass(frozen=True, slots=True)
class Advance:
    """Go on to what comes next: the next repetition or posture, or the robot's help."""


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Play the path at this fraction of the therapist's speed, 0.1 to the prescribed one.

    Raises:
        Refused: The fraction is not 0.1 to 1.
    """

    speed: float

    def __post_init__(self) -> None:
        if not 0.1 <= self.speed <= 1.0:
            raise Refused("speed", f"{self.speed:g}", "0.1 to 1", "choose a speed in this range")


@dataclass(frozen=True, slots=True)
class Pain:
    """The patient reports pain: hold at once."""


@dataclass(frozen=True, slots=True)
class Reset:
    """A person who is present clears a latched hold."""


Order: TypeAlias = Pause | Resume | Reverse | Advance | SetSpeed | Pain | Reset


class Inbox(Protocol):
    """Where a run looks for orders, every few ticks."""

    def take(self, t_ns: int) -> Order | None:
        """The next order that is due at this time of the loop's clock, or None. Never waits."""
        ...


class ScriptedInbox:
    """Orders at fixed times of the loop's clock, for headless runs and tests.

    Args:
        script: Pairs of time in seconds since the clock's zero and order, in order of time.
    """

    def __init__(self, script: tuple[tuple[float, Order], ...] = ()) -> None:
        self._script = deque(script)

    def take(self, t_ns: int) -> Order | None:
        """The next order that is due."""
        if self._script and t_ns >= self._script[0][0] * 1e9:
            return self._script.popleft()[1]
        return None


class Patient(Protocol):
    """The patient's side of the exercise: a real one watches the screen, a virtual one is told here."""

    def cue(self, path_rad: Float64, step_s: float, speed: float) -> None:
        """Ask for the movement; ``path_rad`` (M, J) are its postures, ``step_s`` of path time apart."""
        ...

    def progress(self, path_s: float) -> None:
        """Show how far the movement has come."""
        ...

    def relax(self) -> None:
        """End the request."""
        ...


class PresentPatient:
    """A real patient: the screen cues, nothing needs to be told to software."""

    def cue(self, path_rad: Float64, step_s: float, speed: float) -> None:
        """Nothing: the screen shows the cue."""

    def progress(self, path_s: float) -> None:
        """Nothing: the screen shows the movement."""

    def relax(self) -> None:
        """Nothing."""
