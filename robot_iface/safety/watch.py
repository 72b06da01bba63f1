"""What the supervisor is told once a tick, and what it answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from robot_iface.types import DeviceCommand, Float64, SafetyEvent, SafetyState


@dataclass(frozen=True, slots=True)
class Watch:
    """What the loop knows about everything but the device. The defaults mean "all is well, nothing is armed".

    Attributes:
        heartbeat_age_ns: Since the app last gave a sign of life; 0 where no heartbeat is armed.
        operator_age_ns: Since the operator's page last gave a sign of life or saw a fresh picture; 0 where
            not armed.
        camera_age_ns: Since the last frame, where a camera is in the loop; else 0.
        path_age_ns: Since the set-point was last computed.
        path_fault: Whether the path player had to stop by itself.
        overruns_in_row: Consecutive ticks that missed their deadline.
        repetition_age_ns: Since the repetition began; 0 outside one.
        repetition_timeout_ns: How long a repetition may take; 0 = no bound.
        enable_held: Whether the enable is still given.
        pain: Whether pain was reported since the last tick.
    """

    heartbeat_age_ns: int = 0
    operator_age_ns: int = 0
    camera_age_ns: int = 0
    path_age_ns: int = 0
    path_fault: bool = False
    overruns_in_row: int = 0
    repetition_age_ns: int = 0
    repetition_timeout_ns: int = 0
    enable_held: bool = True
    pain: bool = False


class Outcome(NamedTuple):
    """What became of a request; a tuple, because one is made in every tick. Arrays are (J,).

    Attributes:
        applied: The command that the device has now; with zero gains while it brakes or is unpowered.
        requested_tau_nm: Torque that the request asked for at the present state.
        applied_tau_nm: Torque that the applied command gives at the present state, within the limits.
        safety_state: State of the supervisor after this tick.
        ramp: 0 to 1, the share of torque that RAMP_IN allows so far; 1 when ACTIVE.
        load_share: Largest measured interaction torque as a share of its limit.
        powered: Whether the motors have power.
        events: Transitions of this tick, usually none.
        reversing: Whether the supervisor itself moves the hand back from a load; requests do not pass.
        reversed: In the one tick in which it gives the hand back: the task begins anew from where it is.
    """

    applied: DeviceCommand
    requested_tau_nm: Float64
    applied_tau_nm: Float64
    safety_state: SafetyState
    ramp: float
    load_share: float
    powered: bool
    events: tuple[SafetyEvent, ...]
    reversing: bool = False
    reversed: bool = False
