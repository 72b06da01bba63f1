"""Everything that may pass between app and motion process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_args

from robot_iface.runtime import Order
from robot_iface.types import Certificate, PhaseChange, Plan, RunEnd, SafetyEvent, TickBlock


@dataclass(frozen=True, slots=True)
class Rehearse:
    """Asks for a rehearsal; the answer is a Certificate or a Refusal."""

    plan: Plan


@dataclass(frozen=True, slots=True)
class Start:
    """Asks for a run; the answer is Started or a Refusal, then the run's messages up to its RunEnd."""

    plan: Plan
    certificate: Certificate


@dataclass(frozen=True, slots=True)
class Started:
    """The run has begun."""


@dataclass(frozen=True, slots=True)
class Cleared:
    """A reset between runs has been done."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """A Refused of the other process."""

    thing: str
    value: str
    bound: str
    remedy: str


@dataclass(frozen=True, slots=True)
class Ready:
    """The motion process is up."""


ORDERS: tuple[type[Any], ...] = get_args(Order)
"""What a person may order while a run goes on."""
MESSAGES: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        *(Rehearse, Start, Started, Cleared, Refusal, Ready),
        *ORDERS,
        *(Certificate, PhaseChange, SafetyEvent, TickBlock, RunEnd),
    )
}
"""Every message by its name on the wire."""
