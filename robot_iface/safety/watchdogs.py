"""Checks that need time: ages, counts and loads that last."""

from __future__ import annotations

import math

import numpy as np

from robot_iface.safety.envelope import Finding
from robot_iface.safety.watch import Watch
from robot_iface.types import DeviceState, SafetyState

HEARTBEAT_NS = 250_000_000
OPERATOR_NS = 1_000_000_000
CAMERA_NS = 300_000_000
PATH_NS = 50_000_000
STALE_PERIODS = 2
OVERRUNS = 3
MAX_TEMPERATURE_C = 80.0
LOAD_LASTS_S = 0.010
"""How long a load over its limit is borne. At 25 ms a small spasm was made faster (166 against 113 deg/s
without a supervisor), at 10 ms it is slowed (69 deg/s); the table of faults allows 30 ms."""
REST_LOAD_SHARE = 0.5
REST_LOAD_S = 3.0
COMMANDED_REST_RAD_S = float(np.deg2rad(1.0))
STILL_RAD_S = float(np.deg2rad(5.0))
_NS = 1e-9


class Watchdogs:
    """Time-outs of the loop, the app, the operator, the camera and the device, and loads that last.

    Args:
        period_ns: Control period.
        device_period_ns: Period at which the device renews its state.
    """

    def __init__(self, period_ns: int, device_period_ns: int) -> None:
        self._period_s = period_ns * _NS
        self._stale_ns = STALE_PERIODS * device_period_ns
        self._stale_reads = STALE_PERIODS * max(device_period_ns // period_ns, 1)
        self._last_ns = 0
        self._gap_ns = 0
        self._last_seq = -1
        self._old_reads = 0
        self._over_load_s = 0.0
        self._loaded_s = 0.0

    def trust(self, state: DeviceState, now_ns: int) -> Finding | None:
        """Whether clock and device can be trusted at all (checked in every state).

        A clock that goes backwards makes every age meaningless: category 0. One that jumps ahead looks like a
        loop that stood still (HOLD), or, where the device keeps its own time, like a stale device. A reading
        from the loop's future is no more to be trusted: by its age it would never be stale.
        """
        self._gap_ns = gap_ns = now_ns - self._last_ns if self._last_ns else 0
        self._last_ns = now_ns
        if gap_ns < 0:
            return Finding("clock-backwards", SafetyState.CAT0, "", gap_ns * _NS, 0.0)
        if state.seq > self._last_seq:
            self._old_reads, self._last_seq = 0, state.seq
        else:  # repeated, or overtaken by a later one
            self._old_reads += 1
        age_ns = now_ns - state.t_ns
        if not -PATH_NS <= age_ns <= self._stale_ns or self._old_reads > self._stale_reads:
            return Finding("device-stale", SafetyState.CAT0, "", age_ns * _NS, self._stale_ns * _NS)
        if state.faults:
            return Finding(f"device-fault {state.faults[0]}", SafetyState.CAT1, "", math.nan, math.nan)
        if not state.temperature_c <= MAX_TEMPERATURE_C:
            return Finding("temperature", SafetyState.CAT1, "", state.temperature_c, MAX_TEMPERATURE_C)
        return None

    def link(self, watch: Watch) -> Finding | None:
        """Whether loop, app, operator, camera and path are there (checked while the motors pursue a goal)."""
        well = (
            watch.overruns_in_row <= OVERRUNS
            and watch.heartbeat_age_ns <= HEARTBEAT_NS
            and watch.operator_age_ns <= OPERATOR_NS
            and watch.camera_age_ns <= CAMERA_NS
            and watch.path_age_ns <= PATH_NS
            and self._gap_ns <= PATH_NS
            and watch.enable_held
            and not watch.pain
            and not watch.path_fault
            and (watch.repetition_timeout_ns <= 0 or watch.repetition_age_ns <= watch.repetition_timeout_ns)
        )
        return None if well else self._unwell(watch)

    def _unwell(self, watch: Watch) -> Finding | None:
        """The first of what ``link`` has found, the most severe first."""
        if watch.overruns_in_row > OVERRUNS:
            return Finding("overruns", SafetyState.CAT0, "", float(watch.overruns_in_row), float(OVERRUNS))
        ages = (
            ("heartbeat-lost", SafetyState.CAT1, watch.heartbeat_age_ns, HEARTBEAT_NS),
            ("operator-silent", SafetyState.HOLD, watch.operator_age_ns, OPERATOR_NS),
            ("camera-lost", SafetyState.HOLD, watch.camera_age_ns, CAMERA_NS),
            ("path-stale", SafetyState.HOLD, watch.path_age_ns, PATH_NS),
            ("loop-stalled", SafetyState.HOLD, self._gap_ns, PATH_NS),
        )
        for cause, state, age_ns, bound_ns in ages:
            if age_ns > bound_ns:
                return Finding(cause, state, "", age_ns * _NS, bound_ns * _NS)
        if not watch.enable_held:
            return Finding("enable-released", SafetyState.HOLD, "", math.nan, math.nan)
        if watch.pain:
            return Finding("pain", SafetyState.HOLD, "", math.nan, math.nan)
        if watch.path_fault:
            return Finding("path-fault", SafetyState.HOLD, "", math.nan, math.nan)
        age_s, bound_s = watch.repetition_age_ns * _NS, watch.repetition_timeout_ns * _NS
        return Finding("repetition-time-out", SafetyState.HOLD, "", age_s, bound_s)

    def overloaded(self, load_share: float) -> bool:
        """Whether a load (as a share of its limit) has been over it for 10 ms."""
        self._over_load_s = self._over_load_s + self._period_s if load_share > 1.0 else 0.0
        return self._over_load_s >= LOAD_LASTS_S - _NS

    def stretched(self, load_share: float, commanded_rad_s: float, speed_rad_s: float) -> Finding | None:
        """Whether a load has been above half of its limit for 3 s while the robot holds still.

        Args:
            load_share: Largest interaction torque as a share of its limit.
            commanded_rad_s: Highest commanded speed.
            speed_rad_s: Highest measured speed.
        """
        loaded = (
            load_share > REST_LOAD_SHARE
            and commanded_rad_s < COMMANDED_REST_RAD_S
            and speed_rad_s < STILL_RAD_S
        )
        self._loaded_s = self._loaded_s + self._period_s if loaded else 0.0
        if self._loaded_s >= REST_LOAD_S - _NS:
            return Finding("held-stretch", SafetyState.HOLD, "", load_share, REST_LOAD_SHARE)
        return None

    def forget_loads(self) -> None:
        """Begin to count loads anew: motion is enabled, or the supervisor has gone back on a load."""
        self._over_load_s = 0.0
        self._loaded_s = 0.0
