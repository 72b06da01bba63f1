"""Telemetry for the live page: the newest state of a run, whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from robot_iface.types import Float64, SafetyState

PHASES: tuple[str, ...] = (
    *("", "approach", "ramp", "cue", "move", "hold", "return", "rest", "stopped", "done"),
    *("open", "tabletop", "hook", "fist", "check", "fold", "stretch"),
    *("rest-proposed", "skin-check"),
)
"""The second line holds the parts of a guided sweep, the third the long rests of an exercise."""
STARTERS: tuple[str, ...] = ("", "patient", "robot")


@dataclass(frozen=True, slots=True)
class LiveSample:
    """The newest telemetry of a run. Arrays are (J,) over the driven joints.

    Attributes:
        t_ns: Time on the loop's clock, 0 before the first run.
        q_rad: Measured angles.
        q_reference_rad: The therapist's angles at the present path coordinate.
        tau_interaction_nm: Torque of the device on the patient, flexion positive.
        path_s: Path coordinate.
        path_speed: Path speed.
        repetition: Index from 0, -1 outside a repetition.
        phase: One of PHASES.
        started_by: One of STARTERS.
        safety_state: Supervisor state.
        stiffness_multiple: Stiffness as a multiple of the thesis gains.
        stop_latched_t_ns: Wall-clock monotonic time at which the loop acted on the stop word, 0 if it
            has not.
        late_p99_ns: 99th percentile so far of how late the loop's ticks began, 0 in simulated time.
        overruns: Ticks so far that missed their deadline.
    """

    t_ns: int
    q_rad: Float64
    q_reference_rad: Float64
    tau_interaction_nm: Float64
    path_s: float
    path_speed: float
    repetition: int
    phase: str
    started_by: str
    safety_state: SafetyState
    stiffness_multiple: Float64
    stop_latched_t_ns: int = 0
    late_p99_ns: int = 0
    overruns: int = 0


class Monitor(Protocol):
    """Who watches a run from outside: its signs of life come in, telemetry goes out. Nothing here waits."""

    def heartbeat_age_ns(self) -> int:
        """How long the app has been silent; asked in real time only."""
        ...

    def operator_age_ns(self) -> int:
        """How long the operator's page has been silent, 0 where none watches; asked in real time only."""
        ...

    def publish(self, sample: LiveSample) -> None:
        """Show telemetry."""
        ...

    def latched(self) -> None:
        """Note that the loop has stopped."""
        ...


class Unwatched:
    """Nobody watches: headless runs and rehearsals."""

    def heartbeat_age_ns(self) -> int:
        """Never silent."""
        return 0

    def operator_age_ns(self) -> int:
        """Never silent."""
        return 0

    def publish(self, sample: LiveSample) -> None:
        """Nothing."""

    def latched(self) -> None:
        """Nothing."""
