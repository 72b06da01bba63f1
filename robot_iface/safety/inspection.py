"""Everything that can be wrong in one tick: by the envelope, the watchdogs, the stop and the caller."""

from __future__ import annotations

import math

from robot_iface.ports import EmergencyStop
from robot_iface.safety.envelope import Assessment, Envelope, Finding
from robot_iface.safety.watch import Watch
from robot_iface.safety.watchdogs import Watchdogs
from robot_iface.types import Capabilities, DeviceState, Limits, SafetyState


class Inspection:
    """Finds what is wrong; what to do about it is the supervisor's.

    Args:
        limits: Limits of the driven joints.
        capabilities: The device.
        stop: The stop that a person presses.
        period_ns: Control period.
    """

    def __init__(
        self, limits: Limits, capabilities: Capabilities, stop: EmergencyStop, period_ns: int
    ) -> None:
        self.envelope = Envelope(limits, capabilities.joint_names, period_ns * 1e-9)
        """Checks of the numbers of a tick."""
        self._watchdogs = Watchdogs(period_ns, capabilities.period_ns)
        self._stop = stop
        self._asked = ""
        self._hold: Finding | None = None

    def ask_for_stop(self, cause: str) -> None:
        """Category 1 stop at the next tick."""
        self._asked = cause

    def ask_for_hold(self, cause: str, joint: str, value: float, bound: float) -> None:
        """Hold at the next tick."""
        self._hold = Finding(cause, SafetyState.HOLD, joint, value, bound)

    def forget_loads(self) -> None:
        """Begin to count loads anew."""
        self._watchdogs.forget_loads()

    def findings(
        self, state: DeviceState, now_ns: int, assessed: Assessment, watch: Watch | None, lost: str
    ) -> list[Finding]:
        """Everything that is wrong in this tick, usually nothing.

        Args:
            state: Newest reading.
            now_ns: Time of the loop.
            assessed: What the envelope found.
            watch: What the loop knows; None where the motors pursue no goal.
            lost: What the device failed to do, empty while it answers.
        """
        found: list[Finding] = []
        if self._stop.pressed():
            found.append(Finding("e-stop", SafetyState.CAT1, "", math.nan, math.nan))
        if assessed.findings:
            found.extend(assessed.findings)
        if lost:
            found.append(Finding(f"device-lost {lost}", SafetyState.CAT0, "", math.nan, math.nan))
        if self._asked:
            found.append(Finding(self._asked, SafetyState.CAT1, "", math.nan, math.nan))
            self._asked = ""
        if self._hold is not None:
            found.append(self._hold)
            self._hold = None
        untrusted = self._watchdogs.trust(state, now_ns)
        if untrusted is not None:
            found.append(untrusted)
        if watch is None:
            return found
        unlinked = self._watchdogs.link(watch)
        if unlinked is not None:
            found.append(unlinked)
        if self._watchdogs.overloaded(assessed.load_share):
            found.append(self.envelope.load())
            return found
        stretched = self._watchdogs.stretched(
            assessed.load_share, assessed.commanded_rad_s, assessed.speed_rad_s
        )
        if stretched is not None:
            found.append(stretched)
        return found
