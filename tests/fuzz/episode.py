"""Plays an episode: one run of the whole motion core on a simulated device, with a judge in every tick."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from unittest import mock

import numpy as np

from robot_iface.errors import Refused
from robot_iface.runtime import Rig, Surroundings, perform
from robot_iface.safety import Supervisor
from robot_iface.sim import DRIVEN, SimulatedDlrHit, SimulatedExoskeleton
from robot_iface.types import JOINTS, DeviceCommand, RunEnd
from tests.fuzz.judge import Judge, Tick
from tests.fuzz.script import Script, draw
from tests.fuzz.stage import BadClock, Button, People, SilentApp, SpiedRobot, Time

OUTSIDE_RAD = float(np.deg2rad(6.0))
"""The device itself trips 2 degrees outside; the straps let the hand be elsewhere than the device."""
ERRORS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)
_DRIVEN_IN_HAND = [JOINTS.index(name) for name in DRIVEN]


@dataclass(frozen=True, slots=True)
class Played:
    """What came of an episode."""

    script: Script
    ticks: int
    digest: str
    refused: str
    states: frozenset[str]
    causes: tuple[str, ...]
    reversals: int
    outside_rad: float
    failures: tuple[str, ...]


def play(seed: int) -> Played:
    """Play the episode of a seed."""
    script = draw(seed)
    time = Time(script)
    plan = script.plan
    worn = plan.device == "exoskeleton"
    hand: Any = (
        SimulatedExoskeleton(plan.twin, plan.seed, script.faults)
        if worn
        else SimulatedDlrHit(plan.seed, script.faults)
    )
    robot, clock = SpiedRobot(hand, time, plan.limits), BadClock(hand, time)
    button, app, people = Button(time, script.end_s), SilentApp(time), People(script, time)
    judge = Judge(script, robot, button, app, people)
    said: list[Any] = []
    around = Surroundings(button, said.append, people, app)
    true_rad = (lambda: hand.hand_rad[_DRIVEN_IN_HAND]) if worn else (lambda: hand.joints_rad)
    refused = ""
    with mock.patch.object(Supervisor, "write", spy(judge, time, clock, true_rad)):
        try:
            perform(plan, Rig(robot, clock, hand.patient), around)
        except Refused as error:
            refused = error.thing
        except ERRORS as error:  # whatever it is, it must not leave a run
            judge.fail(f"{type(error).__name__}: {error}")
    return _verdict(script, judge, robot, said, refused)


def _verdict(script: Script, judge: Judge, robot: SpiedRobot, said: list[Any], refused: str) -> Played:
    if robot.mode != "off" or not (robot.closed or refused):
        judge.fail(f"the run has left the device in mode {robot.mode}")
    ended = bool(said) and isinstance(said[-1], RunEnd)
    if refused and judge.ticks:
        judge.fail(f"{refused} was refused after motion had begun")
    if not refused and not ended:
        judge.fail("no RunEnd")
    if script.clean and judge.outside_rad > OUTSIDE_RAD:
        judge.fail(f"{np.rad2deg(judge.outside_rad):.1f} degrees outside its range")
    end = said[-1] if ended else None
    return Played(
        script,
        judge.ticks,
        end.digest if end else "",
        refused,
        frozenset(judge.states),
        tuple(judge.causes),
        end.reversals if end else 0,
        judge.outside_rad if script.clean else 0.0,
        tuple(judge.failures),
    )


def spy(
    judge: Judge, time: Time, clock: BadClock, true_rad: Callable[[], Any]
) -> Callable[[Supervisor, DeviceCommand, Any], Any]:
    """``Supervisor.write`` with a mad law before it and the judge behind it."""
    original = Supervisor.write

    def write(supervisor: Supervisor, request: DeviceCommand, watch: Any) -> Any:
        request = maddened(request, time)
        before = supervisor.state
        outcome = original(supervisor, request, watch)
        reading = judge.robot.reading
        assert reading is not None
        judge.tick(Tick(clock.now_ns(), reading, request, before, outcome, clock.overruns_in_row))
        judge.look(true_rad())
        return outcome

    return write


def maddened(request: DeviceCommand, time: Time) -> DeviceCommand:
    """A request that a broken control law would make, where the script has it so."""
    joint = 1
    push = time.active("mad-push")
    pushed = 0.0 if push is None else push.sign * min(0.02 * (time.tick - push.start), 0.5)
    for kind, field, value in (
        ("mad-push", "tau_ff_nm", pushed),
        ("mad-nan", "q_rad", np.nan),
        ("mad-inf", "tau_ff_nm", -np.inf),
        ("mad-torque", "tau_ff_nm", 3.0),
        ("mad-step", "tau_ff_nm", 0.08 if time.tick % 2 else 0.0),
    ):
        if time.active(kind):
            array = getattr(request, field).copy()
            array[joint] += value
            request = dataclasses.replace(request, **{field: array})
    return request
