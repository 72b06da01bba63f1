"""The guided sweep: alone, then gently led, then back; measured, and never beyond load, speed or range."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.loop import SimulatedClock
from robot_iface.motion.limits import SweepResult, hulls_exceeded, limits_of
from robot_iface.runtime import (
    Advance,
    Order,
    Pain,
    Pause,
    Reset,
    Resume,
    Rig,
    ScriptedInbox,
    SetSpeed,
    Surroundings,
    perform,
)
from robot_iface.runtime.sweep_reading import measured_range, part
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, device_capabilities
from robot_iface.types import (
    Float64,
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    SafetyEvent,
    SafetyState,
    Spasm,
    Sweep,
    TickBlock,
    VirtualKind,
)

DEVICE = device_capabilities()
MCP, PIP = DRIVEN.index("index_mcp_flexion"), DRIVEN.index("index_pip")
GOALS_DEG = {
    "open": {},
    "tabletop": {"mcp_flexion": 80.0},
    "hook": {"pip": 95.0},
    "fist": {"mcp_flexion": 80.0, "pip": 95.0, "thumb_ip": 50.0, "thumb_mcp_flexion": 40.0},
}
SPEED_RAD_S = 0.35
TWO = ("open", "fist")


class NeverPressed:
    def pressed(self) -> bool:
        return False


def goals(postures: tuple[str, ...]) -> Float64:
    rows = [
        [GOALS_DEG[p].get(name) or GOALS_DEG[p].get(name.split("_", 1)[1], 0.0) for name in DRIVEN]
        for p in postures
    ]
    thumb = [name.startswith("thumb") for name in DRIVEN]
    angles = np.deg2rad(np.array(rows))
    named = [[name in GOALS_DEG[p] for name in DRIVEN] for p in postures]
    return np.where(np.array(thumb) & ~np.array(named), 0.0, angles)


def plan(kind: VirtualKind = "healthy", postures: tuple[str, ...] = TWO, **changes: Any) -> Plan:
    sweep = Sweep(
        "range", DRIVEN, "right", postures, goals(postures), **{"speed_rad_s": SPEED_RAD_S, **changes}
    )
    limits = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad, spastic=kind.startswith("mas"))
    return Plan(
        "exoskeleton", None, Prescription("transparent"), limits, PatientTwin(kind), 1, "0", sweep=sweep
    )


class Run:
    def __init__(self, swept: Plan, orders: tuple[tuple[float, Order], ...] = ()) -> None:
        robot = SimulatedExoskeleton(swept.twin, swept.seed)
        self.messages: list[Any] = []
        around = Surroundings(NeverPressed(), self.messages.append, ScriptedInbox(orders))
        rig = Rig(robot, SimulatedClock(DEVICE.period_ns, robot.advance), robot.patient)
        self.plan, self.end = swept, perform(swept, rig, around)
        self.blocks = [m for m in self.messages if isinstance(m, TickBlock)]
        self.phases = [m for m in self.messages if isinstance(m, PhaseChange)]
        self.events = [m for m in self.messages if isinstance(m, SafetyEvent)]

    @property
    def result(self) -> SweepResult:
        assert self.plan.sweep is not None
        return measured_range(self.blocks, self.phases, self.plan.sweep, self.plan.limits, DEVICE)

    def column(self, name: str) -> Float64:
        return np.concatenate([getattr(block, name) for block in self.blocks])

    def during(self, phase: str, index: int, starter: str) -> Any:
        return part(self.column("t_ns").astype(np.int64), self.phases, (phase, index, starter))

    def sequence(self) -> list[tuple[str, int, str]]:
        keys = [(p.phase, p.repetition, p.started_by) for p in self.phases]
        return [key for place, key in enumerate(keys) if place == 0 or keys[place - 1] != key]


RUNS: dict[str, Run] = {}


def ran(kind: VirtualKind) -> Run:
    if kind not in RUNS:
        RUNS[kind] = Run(plan(kind, tuple(GOALS_DEG) if kind in ("healthy", "mas2") else TWO))
    return RUNS[kind]


def test_the_parts_come_in_order_and_the_sweep_completes() -> None:
    run = ran("healthy")
    parts = [
        key
        for index, name in enumerate(GOALS_DEG)
        for key in ((name, index, "patient"), (name, index, "robot"), ("rest", index, "robot"))
    ]
    assert run.sequence() == [("approach", -1, ""), *parts, ("done", 3, "")]
    assert run.end.completed
    assert run.end.reason == "sweep"
    assert run.events == []
    assert run.end.simulated_s < 120.0


def test_a_healthy_hand_makes_every_posture_alone_and_is_led_to_its_end() -> None:
    result = ran("healthy").result
    wanted = np.rad2deg(goals(tuple(GOALS_DEG)))
    assert np.abs(np.rad2deg(result.passive_rad) - wanted).max() < 1.0
    assert np.abs(np.rad2deg(result.active_rad) - wanted).max() < 10.0
    assert not result.patient_end.any()
    assert result.verdict == ""
    assert np.rad2deg(result.rest_rad[MCP]) == pytest.approx(25.0, abs=1.0)


@pytest.mark.parametrize("kind", ["healthy", "mas2", "flaccid", "resisting"])
def test_range_speed_and_load_stay_within_their_bounds(kind: VirtualKind) -> None:
    run = ran(kind)
    limits = run.plan.limits
    q, command = run.column("q_rad"), run.column("q_command_rad")
    assert run.end.completed
    assert bool((q > limits.q_min_rad - 0.02).all() and (q < limits.q_max_rad + 0.02).all())
    assert bool((command > limits.q_min_rad - 0.02).all() and (command < limits.q_max_rad + 0.02).all())
    assert np.abs(run.column("dq_command_rad_s")).max() <= SPEED_RAD_S + 1e-9
    assert (run.column("dq_command_rad_s") >= -limits.extension_speed_rad_s - 1e-9).all()
    share = np.abs(run.column("tau_interaction_nm")) / limits.tau_interaction_nm
    assert share.max() < 0.8
    for index, name in enumerate(run.plan.sweep.postures if run.plan.sweep else ()):
        led = np.flatnonzero(run.during(name, index, "robot"))
        assert share[led[-1000:]].max() < 0.52  # at the end of the passive part


def test_a_spastic_hand_is_led_until_it_carries_half_and_its_ends_are_its_own() -> None:
    result = ran("mas2").result
    limit = ran("mas2").plan.limits.tau_interaction_nm
    share = np.abs(result.load_nm) / limit
    assert result.patient_end[:, MCP].all()
    assert share[:, MCP] == pytest.approx(np.full(4, 0.48), abs=0.02)
    led = np.rad2deg(result.passive_rad[:, MCP])
    assert led[0] == pytest.approx(
        42.0 - np.rad2deg(0.48 * 0.25 / 0.52), abs=2.5
    )  # load / stiffness of the joint
    assert led[1] == pytest.approx(42.0 + np.rad2deg(0.48 * 0.25 / 0.52), abs=2.5)
    assert not result.device_end.any()


def test_limits_follow_from_the_sweep_and_are_narrower_for_the_spastic_hand() -> None:
    made: dict[str, Any] = {}
    for kind in ("healthy", "mas2"):
        run = ran(kind)
        made[kind] = limits_of(
            run.result, run.plan.limits, measured_utc_ns=1, expires_utc_ns=2, wrist_rad=0.0
        )
        assert len(made[kind].hulls) == 4
        rest = np.clip(run.result.rest_rad, made[kind].q_min_rad, made[kind].q_max_rad)[None]
        assert hulls_exceeded(rest, DRIVEN, made[kind].hulls).max() < 1e-6
    assert made["mas2"].q_min_rad[MCP] > made["healthy"].q_min_rad[MCP] + 0.4
    assert made["mas2"].q_max_rad[MCP] < made["healthy"].q_max_rad[MCP] - 0.3


def test_who_does_not_move_is_led_after_a_while() -> None:
    result = ran("flaccid").result
    assert np.abs(result.active_rad[0] - result.rest_rad).max() < np.deg2rad(2.0)
    assert np.abs(result.passive_rad - goals(TWO)).max() < np.deg2rad(1.0)


def test_an_end_at_the_device_is_flagged_as_the_devices() -> None:
    far = plan("flaccid", ("tabletop",), active=False)
    assert far.sweep is not None
    goal = far.sweep.goals_rad.copy()
    goal[0, MCP] = DEVICE.q_max_rad[MCP]
    run = Run(replace(far, sweep=replace(far.sweep, goals_rad=goal)))
    result = run.result
    assert result.device_end[0].tolist() == [name == "index_mcp_flexion" for name in DRIVEN]
    assert not result.patient_end[0, MCP]
    assert np.isnan(result.active_rad).all()
    assert run.sequence()[1] == ("tabletop", 0, "robot")


def test_a_pause_stands_still_and_the_sweep_goes_on() -> None:
    run = Run(plan("healthy", ("fist",), active=False), ((4.0, Pause()), (7.0, Resume())))
    t_s = run.column("t_ns") * 1e-9
    still = run.column("q_command_rad")[(t_s > 5.0) & (t_s < 7.0)]
    assert np.ptp(still, axis=0).max() < 1e-3
    assert run.end.completed
    assert np.abs(run.result.passive_rad - goals(("fist",))).max() < np.deg2rad(1.0)


def test_a_slower_help_takes_longer() -> None:
    usual = Run(plan("flaccid", ("tabletop",), active=False))
    slower = Run(plan("flaccid", ("tabletop",), active=False), ((0.5, SetSpeed(0.5)),))
    assert np.abs(slower.column("dq_command_rad_s")).max() <= 0.5 * SPEED_RAD_S + 1e-9
    assert slower.end.simulated_s > usual.end.simulated_s + 2.0


def test_a_painful_posture_does_not_count_and_is_not_tried_again() -> None:
    orders = ((4.0, Pain()), (7.0, Reset()), (7.5, Resume()))
    run = Run(plan("healthy", ("fist", "open", "tabletop"), active=False), orders)
    assert [event.cause for event in run.events if event.state == SafetyState.HOLD] == ["pain"]
    assert run.sequence().count(("fist", 0, "robot")) == 1
    assert ("rest", 0, "robot") in run.sequence()
    assert ("open", 1, "robot") in run.sequence()
    assert run.end.completed
    result = run.result
    assert np.isnan(result.passive_rad[0]).all()
    assert np.isfinite(result.passive_rad[1]).all()
    limits = limits_of(result, run.plan.limits, measured_utc_ns=1, expires_utc_ns=2, wrist_rad=0.0)
    assert limits.q_max_rad[PIP] <= result.rest_rad[PIP] + 1e-9  # the fist adds nothing


def test_a_posture_that_a_spasm_broke_off_is_led_to_once_more_and_the_spasm_is_no_range() -> None:
    calm = plan("mas2", ("open",), active=False)
    spasm = Spasm(start_s=4.5, duration_s=0.6, size_nm=0.15, joint="index_mcp_flexion")
    run = Run(replace(calm, twin=replace(calm.twin, spasms=(spasm,))))
    assert run.end.completed
    assert run.sequence().count(("open", 0, "robot")) == 1 + min(run.end.reversals, 1)
    reached, undisturbed = run.result.passive_rad, Run(calm).result.passive_rad
    assert np.abs(reached - undisturbed).max() < np.deg2rad(1.5)


def test_advance_takes_the_next_part() -> None:
    run = Run(plan("healthy", ("open", "fist")), ((2.0, Advance()), (2.5, Advance())))
    sequence = run.sequence()
    assert sequence[1:4] == [("open", 0, "patient"), ("open", 0, "robot"), ("rest", 0, "robot")]
    assert int(run.during("open", 0, "patient").sum()) < 1000
    assert int(run.during("open", 0, "robot").sum()) < 1000
    assert run.end.completed


def test_a_sweep_that_is_stopped_cannot_become_limits() -> None:
    run = Run(replace(plan("healthy", ("open",)), stop_at_s=(3.0,)))
    assert not run.end.completed
    assert run.end.reason == "e-stop"
    assert "broken off" in run.result.verdict
    with pytest.raises(Refused, match="broken off"):
        limits_of(run.result, run.plan.limits, measured_utc_ns=1, expires_utc_ns=2, wrist_rad=0.0)


def test_the_same_sweep_gives_the_same_bytes() -> None:
    short = plan("mas2", ("open",))
    assert Run(short).end.digest == Run(short).end.digest


def test_an_unknown_posture_is_refused_with_those_that_are_known() -> None:
    swept = plan("healthy", ("open",))
    assert swept.sweep is not None
    with pytest.raises(Refused, match=r"pinch.*open, tabletop, hook, fist"):
        Run(replace(swept, sweep=replace(swept.sweep, postures=("pinch",))))
