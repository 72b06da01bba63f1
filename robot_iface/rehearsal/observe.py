"""What a dry run showed: the first violation, the highest loads, the error."""

from __future__ import annotations

import math

import numpy as np

from robot_iface.runtime import Message
from robot_iface.types import Float64, PhaseChange, RunEnd, SafetyEvent, SafetyState, TickBlock

_ANGULAR = {"range": "°", "hull": "°", "fit-drift": "°", "sensors-differ": "°", "speed-trip": "°/s"}


class Observer:
    """Receives the messages of a dry run, and is its emergency stop.

    Args:
        joint_names: The J driven joints.
    """

    def __init__(self, joint_names: tuple[str, ...]) -> None:
        self.peak_interaction_nm: Float64 = np.zeros(len(joint_names))
        """Largest interaction torque so far, (J,)."""
        self.first: str | None = None
        """The first violation as a sentence."""
        self._squares = 0.0
        self._count = 0

    @property
    def rms_error_rad(self) -> float:
        """Root mean square error over all joints while the path moved."""
        return math.sqrt(self._squares / max(self._count, 1))

    def pressed(self) -> bool:
        """Stop at the first violation: what comes after it is of no interest."""
        return self.first is not None

    def sink(self, message: Message | RunEnd) -> None:
        """Take one message."""
        match message:
            case SafetyEvent():
                if self.first is None and message.state >= SafetyState.HOLD:
                    self.first = _sentence(message)
            case TickBlock():
                peaks = np.abs(message.tau_interaction_nm).max(axis=0)
                self.peak_interaction_nm = np.maximum(self.peak_interaction_nm, peaks)
                moving = message.path_speed > 0.0
                error = (message.q_rad - message.q_reference_rad)[moving]
                self._squares += float((error**2).sum())
                self._count += error.size
            case PhaseChange() | RunEnd():
                pass


def _sentence(event: SafetyEvent) -> str:
    """Joint, time, value and bound of a supervisor's transition."""
    where = f"{event.joint} " if event.joint else ""
    text = f"{where}{event.cause} at {event.t_ns * 1e-9:.2f} s"
    if math.isfinite(event.value):
        unit = _ANGULAR.get(event.cause, "")
        scale = 180.0 / math.pi if unit else 1.0
        text += f": {event.value * scale:.3g}{unit}, bound {event.bound * scale:.3g}{unit}"
    return text
