"""A small rigid hand that implements the robot port, and a rig that runs the supervisor over it.

Each joint is one inertia (rotor and finger) with the patient as a spring, a damper and an effort in time. It
is a real, if small, simulation: what the supervisor commands decides where it moves.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from robot_iface.control import Goal, ImpedanceLaw, thesis_gains
from robot_iface.motion import PathState, Setpoint
from robot_iface.safety import Supervisor, Watch, shipped_limits
from robot_iface.types import Capabilities, CommandMode, DeviceCommand, DeviceState, SafetyState

NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
PERIOD_NS = 1_000_000
PERIOD_S = 1e-3
ROTOR = 3.3e-4
FINGER = 1.5e-4


class RigidHand:
    def __init__(
        self,
        q_rad: Any = 0.6,
        stiffness: float = 0.04,
        rest_rad: float = 0.6,
        damping: float = 0.005,
        effort: Callable[[float], Any] = lambda t_s: 0.0,
        corrupt: Callable[[DeviceState], DeviceState] = lambda state: state,
        unpowered: Any = "free",
        quick_release: bool = False,
        late_ticks: int | None = None,
    ) -> None:
        joints = len(NAMES)
        self.q = np.zeros(joints) + q_rad
        self.dq = np.zeros(joints)
        self.tau = np.zeros(joints)
        self.ddq = np.zeros(joints)
        self.stiffness, self.rest, self.damping = stiffness, rest_rad, damping
        self.effort, self.corrupt = effort, corrupt
        self.tick = 0
        self.mode = "off"
        self.brake_damping = 0.0
        self.command: DeviceCommand | None = None
        self.late_ticks = late_ticks
        """Delay of torques that the host computes from its readings; None where the device computes them."""
        self.sent: list[tuple[DeviceCommand, Any, Any]] = []
        self.log: list[str] = []
        self.capabilities = Capabilities(
            name="rigid hand",
            simulated=True,
            joint_names=NAMES,
            period_ns=PERIOD_NS,
            q_min_rad=np.full(joints, -0.3),
            q_max_rad=np.full(joints, 2.0),
            tau_max_nm=np.full(joints, 0.6),
            worn=True,
            unpowered=unpowered,
            encoder_std_rad=0.0,
            quick_release=quick_release,
        )

    def open(self) -> None:
        self.log.append("open")

    def read(self) -> DeviceState:
        interaction = self.tau - ROTOR * self.ddq
        return self.corrupt(
            DeviceState(
                self.tick * PERIOD_NS,
                self.tick,
                self.q.copy(),
                self.q.copy(),
                self.dq.copy(),
                self.tau.copy(),
                interaction,
                30.0,
                (),
            )
        )

    def write(self, command: DeviceCommand) -> None:
        assert self.mode != "off", "a command was written to a device without power"
        self.mode = "command"
        self.command = command
        if self.late_ticks is not None:
            self.sent.append((command, self.q.copy(), self.dq.copy()))

    def enable(self) -> None:
        self.log.append("enable")
        self.mode = "enabled"

    def brake(self, damping_nms_rad: float) -> None:
        self.log.append("brake")
        self.mode = "brake"
        self.brake_damping = damping_nms_rad

    def power_off(self) -> None:
        self.log.append("power off")
        self.mode = "off"

    def clear_faults(self) -> None:
        self.log.append("clear")

    def close(self) -> None:
        self.log.append("close")

    def step(self) -> None:
        """Advance by one period, implicitly in every damping."""
        t_s = self.tick * PERIOD_S
        constant, damping = np.zeros(len(NAMES)), np.zeros(len(NAMES))
        if self.mode == "command" and self.late_ticks is not None:
            constant = self._late_torque(self.late_ticks)
        elif self.mode == "command" and self.command is not None:
            command = self.command
            constant = command.tau_ff_nm.copy()
            if command.mode is CommandMode.IMPEDANCE:
                constant += command.stiffness_nm_rad * (command.q_rad - self.q)
                constant += command.damping_nms_rad * command.dq_rad_s
                damping = command.damping_nms_rad
        elif self.mode == "brake":
            damping = damping + self.brake_damping
        patient = self.stiffness * (self.rest - self.q) + self.effort(t_s)
        total = ROTOR + FINGER
        new = (self.dq + PERIOD_S / total * (constant + patient)) / (
            1.0 + PERIOD_S / total * (damping + self.damping)
        )
        self.ddq = (new - self.dq) / PERIOD_S
        self.dq = new
        self.tau = constant - damping * new
        self.q = self.q + PERIOD_S * new
        self.tick += 1

    def _late_torque(self, ticks: int) -> Any:
        """Constant over the tick, from a reading and a command that are this old."""
        command, q, dq = self.sent[max(len(self.sent) - 1 - ticks, 0)]
        torque = command.stiffness_nm_rad * (command.q_rad - q) + command.tau_ff_nm
        return np.clip(torque + command.damping_nms_rad * (command.dq_rad_s - dq), -0.6, 0.6)


class FlippedHand(RigidHand):
    """Both sensors of every joint count the wrong way, and the device's own loop believes them."""

    def read(self) -> DeviceState:
        state, start = super().read(), self.rest
        seen = {"q_rad": 2.0 * start - self.q, "q_second_rad": 2.0 * start - self.q, "dq_rad_s": -self.dq}
        return dataclasses.replace(state, **seen)

    def write(self, command: DeviceCommand) -> None:
        super().write(command)
        torque = command.stiffness_nm_rad * (command.q_rad - 2.0 * self.rest + self.q) + command.tau_ff_nm
        torque = np.clip(torque + command.damping_nms_rad * (command.dq_rad_s + self.dq), -0.6, 0.6)
        zeros = np.zeros(len(NAMES))
        self.command = DeviceCommand(CommandMode.TORQUE, zeros, zeros, torque, zeros, zeros, command.seq)


class Button:
    def __init__(self) -> None:
        self.down = False

    def pressed(self) -> bool:
        return self.down


class Rig:
    """Supervisor, impedance law and rigid hand, one cycle at a time."""

    def __init__(
        self,
        multiple: float = 3.0,
        ramp_s: float = 1.0,
        limits: Any = None,
        device: type[RigidHand] = RigidHand,
        **hand: Any,
    ) -> None:
        self.hand = device(**hand)
        self.button = Button()
        self.limits = limits or shipped_limits(NAMES, np.zeros(3), np.full(3, 1.6))
        self.supervisor = Supervisor(self.hand, self.limits, self.button, PERIOD_NS, ramp_s=ramp_s)
        self.law = ImpedanceLaw(thesis_gains(NAMES), self.limits)
        self.multiple = multiple
        self.goal = self.hand.q.copy()
        self.speed = np.zeros(3)
        self.change: Callable[[DeviceCommand], DeviceCommand] = lambda request: request
        self.watch = Watch()
        self.outcomes: list[Any] = []
        self.states: list[DeviceState] = []
        self.seq = 0

    def cycle(self) -> Any:
        self.goal = self.goal + self.speed * PERIOD_S
        state = self.supervisor.read(self.hand.tick * PERIOD_NS)
        setpoint = Setpoint(self.goal, self.speed, np.zeros(3))
        self.seq += 1
        goal = Goal(setpoint, np.full(3, self.multiple), np.zeros(3), PathState(0.0, 0.0, 0.0, False))
        request = self.law.command(state, goal, self.supervisor.ramp, self.seq)
        outcome = self.supervisor.write(self.change(request), self.watch)
        if outcome.reversed:
            self.goal = state.q_rad.copy()  # what a task does with a hand that is given back
        self.hand.step()
        self.outcomes.append(outcome)
        self.states.append(state)
        return outcome

    def run(self, ticks: int, **watch: Any) -> Any:
        self.watch = dataclasses.replace(self.watch, **watch)
        for _ in range(ticks):
            outcome = self.cycle()
        return outcome

    def go_active(self) -> None:
        self.supervisor.start()
        self.run(3)
        self.supervisor.enable_edge()
        for _ in range(5000):
            if self.cycle().safety_state is SafetyState.ACTIVE:
                return
        raise AssertionError(f"never active: {self.events()}")

    def glide(self, speed_rad_s: Any, seconds: float) -> Any:
        self.speed = np.zeros(3) + speed_rad_s
        outcome = self.run(round(seconds / PERIOD_S))
        self.speed = np.zeros(3)
        return outcome

    def ticks_until(self, state: SafetyState, at_most: int) -> int:
        """How many cycles pass until a state is entered (1 = in the first cycle)."""
        for tick in range(1, at_most + 1):
            if self.cycle().safety_state is state:
                return tick
        raise AssertionError(f"not {state.name} within {at_most} ticks: {self.events()}")

    def events(self) -> list[Any]:
        return [event for outcome in self.outcomes for event in outcome.events]

    def causes(self) -> list[str]:
        return [event.cause for event in self.events()]


OPEN_SPASTIC = {"q_rad": 0.9, "stiffness": 0.4, "rest_rad": 0.9}


def stretch(**hand: Any) -> Any:
    """A spastic hand held open by the robot, at rest."""
    rig = Rig(multiple=6.0, **(OPEN_SPASTIC | hand))
    rig.go_active()
    rig.glide(-0.2, 1.3)
    rig.run(500)
    assert rig.events() == []
    return rig


def peak_speed_deg_s(rig: Any, ticks: int) -> float:
    rig.run(ticks)
    return float(np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[-ticks:]]).max()))
