"""Faults that a test can plant in the simulated device or in the patient's hand."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from robot_iface.sim.model import DRIVEN
from robot_iface.types import DeviceState, Float64

FaultKind = Literal["freeze", "nan", "sensor-offset", "over-temperature", "device-fault", "spasm"]


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault and when it is there.

    Attributes:
        kind: freeze: the state is not renewed; nan: the joint reads not-a-number; sensor-offset: the joint's
            first sensor reads ``size`` rad too much; over-temperature: the motors report ``size`` degrees
            Celsius; device-fault: the device reports a fault; spasm: the patient's joint pulls with ``size``
            Nm (flexion positive).
        start_s: Since the device was opened.
        duration_s: How long it lasts.
        joint: Driven joint, empty for all of them.
        size: See ``kind``.
    """

    kind: FaultKind
    start_s: float
    duration_s: float = float("inf")
    joint: str = ""
    size: float = 0.0

    def active(self, t_s: float) -> bool:
        """Whether the fault is there at this time."""
        return self.start_s <= t_s < self.start_s + self.duration_s

    def on_joints(self) -> Float64:
        """1 for each joint concerned, else 0, (12,)."""
        return np.array([1.0 if self.joint in ("", name) else 0.0 for name in DRIVEN])


class FaultInjector:
    """Plants faults at their times.

    Args:
        faults: What to plant.
    """

    def __init__(self, faults: Iterable[Fault] = ()) -> None:
        every = tuple(faults)
        self._spasms = tuple((fault, fault.on_joints()) for fault in every if fault.kind == "spasm")
        self._readings = tuple((fault, fault.on_joints()) for fault in every if fault.kind != "spasm")
        self._frozen: DeviceState | None = None

    def torque_nm(self, t_s: float) -> Float64 | None:
        """Spasm torque on the patient's joints, (12,), or None."""
        torques = [fault.size * joints for fault, joints in self._spasms if fault.active(t_s)]
        return np.sum(torques, axis=0) if torques else None

    def reading(self, state: DeviceState, t_s: float) -> DeviceState:
        """The state as the faulty device reports it."""
        if not self._readings:
            return state
        frozen = False
        for fault, joints in self._readings:
            if fault.active(t_s):
                frozen = frozen or fault.kind == "freeze"
                state = _distorted(state, fault, joints)
        if not frozen:
            self._frozen = None
            return state
        self._frozen = self._frozen or state
        return self._frozen


def _distorted(state: DeviceState, fault: Fault, joints: Float64) -> DeviceState:
    if fault.kind == "nan":
        return replace(state, q_rad=np.where(joints > 0, np.nan, state.q_rad))
    if fault.kind == "sensor-offset":
        return replace(state, q_rad=state.q_rad + fault.size * joints)
    if fault.kind == "over-temperature":
        return replace(state, temperature_c=fault.size)
    if fault.kind == "device-fault":
        return replace(state, faults=("motor-driver",))
    return state
