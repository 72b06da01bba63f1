"""Faults that a test can plant in a simulated device or in the patient's hand."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from robot_iface.errors import Refused
from robot_iface.sim.kernels import SIGN, ZERO
from robot_iface.types import DeviceState, Float64, Spasm

FaultKind = Literal[
    "freeze",
    "delayed",
    "lost",
    "reordered",
    "nan",
    "inf",
    "stuck",
    "sensor-offset",
    "wrong-sign",
    "wrong-sign-interaction",
    "over-temperature",
    "device-fault",
    "read-error",
    "write-error",
    "spasm",
]
_ON_THE_WAY: tuple[FaultKind, ...] = ("freeze", "delayed", "lost", "reordered")
_LONGEST_DELAY = 10_000
_IN_THE_SENSOR: tuple[FaultKind, ...] = ("wrong-sign", "sensor-offset")


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault and when it is there.

    Attributes:
        kind: On the way from the device: freeze: the state is not renewed; delayed: it comes ``size`` ticks
            late; lost: ``size`` of every 2 ``size`` readings do not arrive (0 counts as 1), the last one is
            repeated; reordered: two readings in a row come in the wrong order.
            In the sensors: nan, inf: the joint reads not-a-number or infinity; stuck: its first sensor stays
            where it was; sensor-offset: its first sensor reads ``size`` rad too much; wrong-sign: both its
            sensors and its speed count the wrong way; wrong-sign-interaction: its torque sensor does.
            Offset and sign also mislead the device's own position loop.
            In the device: over-temperature: the motors report ``size`` degrees Celsius; device-fault: it
            reports a fault; read-error, write-error: the line fails (OSError).
            In the patient: spasm: the joint is pulled with ``size`` Nm (flexion positive).
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

    def on_joints(self, names: tuple[str, ...]) -> Float64:
        """1 for each of these joints that is concerned, else 0, (J,).

        Raises:
            Refused: There is no such joint.
        """
        if self.joint and self.joint not in names:
            bound = "empty or one of " + ", ".join(names)
            raise Refused(f"joint of the fault {self.kind}", repr(self.joint), bound, "choose one of these")
        return np.array([1.0 if self.joint in ("", name) else 0.0 for name in names])


class FaultInjector:
    """Plants faults at their times.

    Args:
        faults: What to plant.
        names: The J driven joints of the device.

    Raises:
        Refused: A fault names a joint that the device does not have.
    """

    def __init__(self, faults: Iterable[Fault], names: tuple[str, ...]) -> None:
        every = tuple((fault, fault.on_joints(names)) for fault in faults)
        self.spasms = tuple(
            Spasm(fault.start_s, fault.duration_s, fault.size, fault.joint)
            for fault, _ in every
            if fault.kind == "spasm"
        )
        """Spasms among the faults, for the patient."""
        self._sensors = tuple(pair for pair in every if pair[0].kind in _IN_THE_SENSOR)
        self._way = tuple(_Way(fault) for fault, _ in every if fault.kind in _ON_THE_WAY)
        elsewhere = (*_IN_THE_SENSOR, *_ON_THE_WAY, "spasm", "write-error", "read-error")
        self._readings = tuple(pair for pair in every if pair[0].kind not in elsewhere)
        self._lines = tuple(fault for fault, _ in every if fault.kind in ("read-error", "write-error"))
        self._stuck_rad: dict[Fault, Float64] = {}

    def turn_sensors(self, t_s: float, sensors: Float64) -> None:
        """Sign and zero error of the joints' sensors at this time, (2, J), set in place."""
        if not self._sensors:
            return
        sensors[SIGN], sensors[ZERO] = 1.0, 0.0
        for fault, joints in self._sensors:
            if not fault.active(t_s):
                continue
            if fault.kind == "sensor-offset":
                sensors[ZERO] += fault.size * joints
            else:
                sensors[SIGN] *= 1.0 - 2.0 * joints

    def check_line(self, kind: FaultKind, t_s: float) -> None:
        """Fail as a line does that cannot be read or written.

        Args:
            kind: "read-error" or "write-error".
            t_s: Time since the device was opened.

        Raises:
            OSError: The line is faulty at this time.
        """
        for fault in self._lines:
            if fault.kind == kind and fault.active(t_s):
                raise OSError(f"the simulated device answers no more ({kind})")

    def reading(self, state: DeviceState, t_s: float) -> DeviceState:
        """The state as the faulty device reports it."""
        for fault, joints in self._readings:
            if fault.active(t_s):
                state = self._distorted(state, fault, joints)
        for way in self._way:
            state = way.arriving(state, t_s)
        return state

    def _distorted(self, state: DeviceState, fault: Fault, joints: Float64) -> DeviceState:
        match fault.kind:
            case "nan" | "inf":
                nothing = np.nan if fault.kind == "nan" else np.inf
                return replace(state, q_rad=np.where(joints > 0, nothing, state.q_rad))
            case "stuck":
                kept = self._stuck_rad.setdefault(fault, state.q_rad.copy())
                speeds = np.where(joints > 0, 0.0, state.dq_rad_s)
                return replace(state, q_rad=np.where(joints > 0, kept, state.q_rad), dq_rad_s=speeds)
            case "wrong-sign-interaction":
                return replace(state, tau_interaction_nm=state.tau_interaction_nm * (1.0 - 2.0 * joints))
            case "over-temperature":
                return replace(state, temperature_c=fault.size)
            case _:
                return replace(state, faults=("motor-driver",))


class _Way:
    """What a bad line makes of the order of readings.

    Args:
        fault: The fault of the line.
    """

    def __init__(self, fault: Fault) -> None:
        self._fault = fault
        self._sent: deque[DeviceState] = deque(maxlen=max(int(min(fault.size, _LONGEST_DELAY)), 2) + 1)
        self._count = 0
        self._last: DeviceState | None = None

    def arriving(self, state: DeviceState, t_s: float) -> DeviceState:
        """What arrives instead of the newest state."""
        if self._sent and self._sent[-1].seq == state.seq:
            return self._last or state  # read twice within one period
        self._sent.append(state)
        if not self._fault.active(t_s):
            self._last, self._count = state, 0
            return state
        self._last = self._late(state)
        self._count += 1
        return self._last

    def _late(self, state: DeviceState) -> DeviceState:
        last = self._last or state
        size = max(int(min(self._fault.size, _LONGEST_DELAY)), 1)
        match self._fault.kind:
            case "freeze":
                return last if self._count else state
            case "delayed":
                old = self._sent[max(-size - 1, -len(self._sent))]
                return old if old.seq > last.seq else last
            case "lost":
                return last if self._count % (2 * size) < size else state
            case _:
                return state if self._count % 2 else self._sent[max(-3, -len(self._sent))]
