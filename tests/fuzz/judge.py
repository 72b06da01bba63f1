"""What must be true in every tick, written down from the table of faults, not from the supervisor's code."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robot_iface.safety import Outcome
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, SafetyState
from tests.fuzz.script import Script
from tests.fuzz.stage import PERIOD_NS, Button, People, SilentApp, SpiedRobot

READY, RAMP_IN, ACTIVE, HOLD = SafetyState.READY, SafetyState.RAMP_IN, SafetyState.ACTIVE, SafetyState.HOLD
COMPLIANT, CAT1, CAT0 = SafetyState.COMPLIANT, SafetyState.CAT1, SafetyState.CAT0
PURSUING = (RAMP_IN, ACTIVE, HOLD, COMPLIANT)
GUIDED = (RAMP_IN, ACTIVE, HOLD)
MODES = {READY: ("brake", "off"), CAT1: ("brake", "off"), CAT0: ("off",)}
LOAD_TICKS = 30
STALE_READS = 3
SENSORS_RAD = float(np.deg2rad(5.0))
ROUNDING = 1e-9


@dataclass
class Tick:
    """One call of the supervisor's ``write``, and what went before it."""

    now_ns: int
    reading: DeviceState
    request: DeviceCommand
    before: SafetyState
    outcome: Outcome
    overruns: int


@dataclass
class Judge:
    """Looks at every tick of an episode and lists what must not be."""

    script: Script
    robot: SpiedRobot
    button: Button
    app: SilentApp
    people: People
    failures: list[str] = field(default_factory=list)
    states: set[str] = field(default_factory=set)
    causes: list[str] = field(default_factory=list)
    ticks: int = 0
    outside_rad: float = 0.0

    def __post_init__(self) -> None:
        self._last_ns, self._seq, self._old, self._over = 0, -1, 0, 0
        self._state, self._previous, self._lost = READY, None, False
        self._reversing = False

    def tick(self, tick: Tick) -> None:
        """Judge one tick."""
        self.ticks += 1
        after = tick.outcome.safety_state
        self.states.add(after.name)
        self.causes += [event.cause for event in tick.outcome.events]
        for demanded, why in self._demands(tick):
            if after < demanded:
                self.fail(f"{why}: {after.name} instead of {demanded.name}")
        self._check_order(tick.before, after)
        self._check_device(tick.reading, after, tick.outcome)
        self._reversing, self._state = tick.outcome.reversing, after
        self.people.pain = False  # what is reported to a hand at rest does not keep a person from enabling it

    def fail(self, what: str) -> None:
        self.failures.append(f"seed {self.script.seed}, tick {self.ticks}: {what}")

    def _demands(self, tick: Tick) -> list[tuple[SafetyState, str]]:
        """States that this tick must have reached, and why: the rows of the table."""
        rows = [*self._of_trust(tick)]
        finite = all(np.isfinite(row).all() for row in _numbers(tick.reading))
        if not finite:
            return [*rows, (CAT0, "a reading is not finite")]
        if np.abs(tick.reading.q_rad - tick.reading.q_second_rad).max() > SENSORS_RAD + ROUNDING:
            rows.append((CAT0, "sensors differ"))
        pursuing = tick.before in PURSUING
        self._over = self._over + 1 if pursuing and self._load(tick.reading) > 1.0 else 0
        if pursuing:
            rows += [*self._of_motion(tick), *self._of_people(tick.overruns)]
        following = tick.before in (RAMP_IN, ACTIVE) and not self._reversing
        if following:
            rows += self._of_request(tick)
        self._previous = tick.request if following else None
        return rows

    def _of_trust(self, tick: Tick) -> list[tuple[SafetyState, str]]:
        reading, robot = tick.reading, self.robot
        self._old = 0 if reading.seq > self._seq else self._old + 1
        self._seq = max(self._seq, reading.seq)
        backwards, self._last_ns = tick.now_ns < self._last_ns, tick.now_ns
        lost, self._lost, robot.write_failed = self._lost, robot.write_failed, False
        rows = (
            (self.button.pressed(), CAT1, "the stop is pressed"),
            (robot.read_failed or lost, CAT0, "the device does not answer"),
            (backwards, CAT0, "the clock goes backwards"),
            (self._old >= STALE_READS, CAT0, "the device repeats itself"),
            (tick.now_ns - reading.t_ns > STALE_READS * PERIOD_NS, CAT0, "the reading is old"),
            (reading.t_ns - tick.now_ns > 50 * PERIOD_NS, CAT0, "the reading is from the future"),
            (bool(reading.faults), CAT1, "the device reports a fault"),
            (reading.temperature_c > 80.0, CAT1, "the motors are hot"),
        )
        return [(state, why) for holds, state, why in rows if holds]

    def _of_motion(self, tick: Tick) -> list[tuple[SafetyState, str]]:
        reading, limits = tick.reading, self.script.plan.limits
        beyond = np.maximum(limits.q_min_rad - reading.q_rad, reading.q_rad - limits.q_max_rad).max()
        hard, long = self._load(reading) > 1.5 + ROUNDING, self._over > LOAD_TICKS
        rows = (
            (np.abs(reading.dq_rad_s).max() > limits.trip_speed_rad_s + ROUNDING, CAT1, "too fast"),
            (beyond > limits.margin_rad + ROUNDING, CAT1, "out of its range"),
            (hard, COMPLIANT, "loaded far over the limit"),
            (long and not tick.outcome.reversing, COMPLIANT, "loaded over the limit"),
        )
        return [(state, why) for holds, state, why in rows if holds]

    def _of_people(self, overruns: int) -> list[tuple[SafetyState, str]]:
        watched = self.script.plan.realtime
        rows = (
            (watched and self.app.heartbeat_age_ns() > 250_000_000, CAT1, "the app is silent"),
            (watched and self.app.operator_age_ns() > 1_000_000_000, HOLD, "the operator is silent"),
            (watched and overruns > 3, CAT0, "overruns"),
            (self.people.pain, HOLD, "pain"),
        )
        return [(state, why) for holds, state, why in rows if holds]

    def _of_request(self, tick: Tick) -> list[tuple[SafetyState, str]]:
        request, limits = tick.request, self.script.plan.limits
        parts = (request.q_rad, request.dq_rad_s, request.tau_ff_nm)
        if not all(np.isfinite(part).all() for part in parts):
            return [(CAT0, "a request is not finite")]
        torque = torque_of(request, tick.reading)
        if (np.abs(torque) > 3.0 * limits.tau_nm + ROUNDING).any():
            return [(CAT1, "a request of three times the motor's cap")]
        before = self._previous
        if before is None:
            return []
        step = np.abs(torque - torque_of(before, tick.reading)).max()
        return [(CAT1, "a step of torque")] if step > limits.tau_rate_nm_s * 1e-3 + ROUNDING else []

    def _load(self, reading: DeviceState) -> float:
        return float((np.abs(reading.tau_interaction_nm) / self.script.plan.limits.tau_interaction_nm).max())

    def _check_order(self, before: SafetyState, after: SafetyState) -> None:
        """States only get worse; what is latched is left by a person's reset alone."""
        reset, self.people.reset = self.people.reset, False
        if after < before:
            self.fail(f"from {before.name} to {after.name} within a tick")
        if before != self._state:
            left = self._state
            fair = left in (READY, RAMP_IN, ACTIVE) or (reset and left in (HOLD, COMPLIANT))
            if before not in (READY, RAMP_IN) or not fair:
                self.fail(f"from {left.name} to {before.name} between ticks")

    def _check_device(self, reading: DeviceState, after: SafetyState, outcome: Outcome) -> None:
        """What the device was told, and what it does now."""
        written, robot = list(self.robot.written), self.robot
        robot.written.clear()
        if robot.mode not in MODES.get(after, ("command", "enabled")):
            self.fail(f"the device is in mode {robot.mode} in {after.name}")
        if (robot.mode == "off") == outcome.powered:
            self.fail(f"powered {outcome.powered}, but the device is in mode {robot.mode}")
        if len(written) > (after in PURSUING):
            self.fail(f"{len(written)} commands in {after.name}")
        limits = self.script.plan.limits
        tight = after in GUIDED and not outcome.reversing
        cap = np.minimum(limits.tau_nm, 0.95 * limits.tau_interaction_nm) if tight else limits.tau_nm
        for command in written:
            torque = torque_of(command, reading)
            if not (np.abs(torque) <= cap + ROUNDING).all():  # a NaN is no torque within a cap either
                self.fail(f"commanded {np.abs(torque).max():.3f} Nm in {after.name}")

    def look(self, true_rad: Float64) -> None:
        """Take the true angles of the driven joints, (J,): a powered hand stays in its range."""
        limits = self.script.plan.limits
        if self.robot.mode != "off":
            beyond = np.maximum(limits.q_min_rad - true_rad, true_rad - limits.q_max_rad).max()
            self.outside_rad = max(self.outside_rad, float(beyond))


def torque_of(command: DeviceCommand, reading: DeviceState) -> Any:
    """What a command asks of the motors at a reading, (J,)."""
    if command.mode is CommandMode.TORQUE:
        return command.tau_ff_nm
    spring = command.stiffness_nm_rad * (command.q_rad - reading.q_rad)
    return spring + command.damping_nms_rad * (command.dq_rad_s - reading.dq_rad_s) + command.tau_ff_nm


def _numbers(reading: DeviceState) -> tuple[Float64, ...]:
    place = (reading.q_rad, reading.q_second_rad, reading.dq_rad_s)
    return (*place, reading.tau_nm, reading.tau_interaction_nm)
