"""What a run is busy with: a path played in a mode, or a guided sweep. The cycle knows no more of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from robot_iface.control.goal import Goal
from robot_iface.motion import PathState
from robot_iface.types import DeviceState, Float64


@dataclass(frozen=True, slots=True)
class Remark:
    """What a task has to say beside its phases.

    Attributes:
        cause: Stable code such as "fatigue", "skin-check" or "fit-drift".
        holds: Whether the supervisor is to hold for it; otherwise it is only recorded.
        joint: Joint concerned, empty if none.
        value: Value met, SI, NaN if none.
        bound: Bound that applied, SI, NaN if none.
    """

    cause: str
    holds: bool = False
    joint: str = ""
    value: float = float("nan")
    bound: float = float("nan")


class Task(Protocol):
    """The sequence of phases of one run, advanced once a tick. Arrays are (J,)."""

    @property
    def phase(self) -> str:
        """Present phase, one of PHASES."""
        ...

    @property
    def repetition(self) -> int:
        """Index of the repetition (of the posture, in a sweep) from 0; -1 outside one."""
        ...

    @property
    def started_by(self) -> str:
        """Who started it, one of STARTERS."""
        ...

    @property
    def path_state(self) -> PathState:
        """Where the path stands; all zero without a path."""
        ...

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do and the hand is back."""
        ...

    @property
    def reason(self) -> str:
        """Why it came to its end, empty while it has not: see ``RunEnd.reason``.

        A reason of a task that is not done asks for a stop.
        """
        ...

    @property
    def paused(self) -> bool:
        """Whether a pause was asked for and not yet resumed."""
        ...

    @property
    def fault(self) -> str:
        """What the path player refused; empty while it plays."""
        ...

    @property
    def reference_rad(self) -> Float64:
        """Where the hand should be by the therapist's movement."""
        ...

    @property
    def stiffness_multiple(self) -> Float64:
        """Stiffness of the last tick as a multiple of the thesis gains."""
        ...

    @property
    def assistance(self) -> tuple[tuple[float, ...], ...]:
        """Assistance reached, as ``Prescription.assistance``; empty where there is none."""
        ...

    @property
    def repetition_age_ns(self) -> int:
        """How long this repetition has been going on, pauses left out; 0 outside one."""
        ...

    @property
    def repetition_timeout_ns(self) -> int:
        """How long it may take."""
        ...

    def take_remark(self) -> Remark | None:
        """What it has to say since it was last asked, usually nothing; asked once a tick."""
        ...

    def begin(self, q_rad: Float64) -> None:
        """Motion is enabled with the hand here: lead it from here to where it should be."""
        ...

    def resting_goal(self) -> Goal:
        """A goal without stiffness, before the first step."""
        ...

    def step(self, state: DeviceState, load_share: float, active: bool) -> Goal:
        """What this tick asks for.

        Args:
            state: Newest reading.
            load_share: Largest interaction torque as a share of its limit, one tick ago.
            active: Whether requests pass in full; until then the hand is held where it is.
        """
        ...

    def pause(self) -> None:
        """Come to rest."""
        ...

    def resume(self) -> None:
        """Go on."""
        ...

    def reverse(self) -> None:
        """Go back along the path, to its start at most; ``resume`` goes forward again."""
        ...

    def advance(self) -> None:
        """A person asks for the next posture or repetition."""
        ...

    def slow_down_to(self, speed: float) -> None:
        """Play at this path speed, never faster than prescribed."""
        ...

    def trouble(self) -> None:
        """Pain, or a latched state, in this repetition: nothing is learnt from it and help is not raised."""
        ...

    def reversed_on_load(self, q_rad: Float64) -> None:
        """The supervisor has gone back on a load and gives the hand, which is here, back to this task."""
        ...
