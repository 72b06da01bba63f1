"""What the motion process reports while it runs and when it is done."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from robot_iface.types.hand import Float64, Int64, UInt8


class SafetyState(IntEnum):
    """States of the supervisor. HOLD and below HOLD in this list are latched."""

    OFF = 0
    READY = 1
    RAMP_IN = 2
    ACTIVE = 3
    HOLD = 4
    COMPLIANT = 5
    CAT1 = 6
    CAT0 = 7


@dataclass(frozen=True, slots=True)
class SafetyEvent:
    """A supervisor transition and what caused it.

    Attributes:
        t_ns: Time on the loop's clock.
        cause: Stable code such as "e-stop", "heartbeat-lost", "speed-trip".
        state: State entered.
        joint: Joint concerned, empty if none.
        value: Value met, SI, NaN if none.
        bound: Bound that applied, SI, NaN if none.
    """

    t_ns: int
    cause: str
    state: SafetyState
    joint: str
    value: float
    bound: float


@dataclass(frozen=True, slots=True)
class PhaseChange:
    """Where the run stands; reported at every change and at 10 Hz.

    Attributes:
        t_ns: Time on the loop's clock.
        repetition: Index from 0, -1 outside a repetition.
        phase: approach, ramp, cue, move, hold, return, rest, stopped or done.
        started_by: "patient", "robot" or "".
        path_s: Path coordinate.
        path_speed: Path speed.
        stiffness_multiple: Stiffness by driven joint as a multiple of the thesis gains, (J,).
    """

    t_ns: int
    repetition: int
    phase: str
    started_by: str
    path_s: float
    path_speed: float
    stiffness_multiple: Float64


@dataclass(frozen=True, slots=True)
class TickBlock:
    """Up to 50 consecutive ticks. Arrays are (n,) or (n, J) over the driven joints."""

    t_ns: Int64
    q_rad: Float64
    dq_rad_s: Float64
    tau_nm: Float64
    tau_interaction_nm: Float64
    path_s: Float64
    path_speed: Float64
    safety_state: UInt8
    q_reference_rad: Float64
    q_command_rad: Float64
    dq_command_rad_s: Float64
    stiffness_nm_rad: Float64
    damping_nms_rad: Float64
    tau_ff_nm: Float64
    tau_requested_nm: Float64
    tau_applied_nm: Float64


@dataclass(frozen=True, slots=True)
class RunEnd:
    """How a run ended.

    Attributes:
        simulated_s: Time on the loop's clock from first to last tick.
        completed: Whether every repetition was made.
        state: Supervisor state at the end.
        late_p99_ns: 99th percentile of wake-up lateness in real time, 0 in simulated time.
        overruns: Ticks that missed their deadline in real time.
        digest: SHA-256 over every block, phase and event in order.
        reason: Why it ended: repetitions, minutes, reversals, fatigue, skin-check, sweep, or a stop's cause.
        reversals: How often the supervisor went back on a load.
        assistance: Assistance reached, as ``Prescription.assistance``; empty where there was none.
        scheduling: What scheduling the loop had, as a phrase.
    """

    simulated_s: float
    completed: bool
    state: SafetyState
    late_p99_ns: int
    overruns: int
    digest: str
    reason: str = ""
    reversals: int = 0
    assistance: tuple[tuple[float, ...], ...] = ()
    scheduling: str = ""
