"""The tone test: spastic hands oppose a fast stretch more, healthy and short ones do not; bounds are kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.rehearsal import rehearse
from robot_iface.runtime.sweep_tone import ToneTest
from robot_iface.runtime.sweep_tone_reading import ToneResult, tone_result
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN
from robot_iface.types import PatientTwin, Plan, Prescription, Sweep, VirtualKind
from tests.robot_iface.runtime.test_sweep import DEVICE, MCP, PIP, Run

FINGERS = np.array([name.endswith(("mcp_flexion", "pip")) and name[:5] != "thumb" for name in DRIVEN])
SPEEDS = tuple(float(np.deg2rad(speed)) for speed in (10.0, 10.0, 80.0, 80.0))


def plan(kind: VirtualKind, extension_deg_s: float = 90.0) -> Plan:
    limits = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad, spastic=kind.startswith("mas"))
    limits = replace(limits, extension_speed_rad_s=np.full(len(DRIVEN), np.deg2rad(extension_deg_s)))
    rest = np.clip(np.deg2rad(20.0), limits.q_min_rad, limits.q_max_rad)
    start = np.where(FINGERS, np.deg2rad(50.0), rest)
    goal = np.where(FINGERS, np.deg2rad(10.0), start)
    sweep = Sweep(
        "tone",
        DRIVEN,
        "right",
        ("stretch",) * len(SPEEDS),
        np.tile(goal, (len(SPEEDS), 1)),
        speed_rad_s=0.35,
        dwell_s=0.3,
        stretch_rad_s=SPEEDS,
        start_rad=tuple(start.tolist()),
    )
    return Plan(
        "exoskeleton", None, Prescription("transparent"), limits, PatientTwin(kind), 1, "0", sweep=sweep
    )


RUNS: dict[VirtualKind, tuple[Run, ToneResult]] = {}


def ran(kind: VirtualKind) -> tuple[Run, ToneResult]:
    if kind not in RUNS:
        run = Run(plan(kind))
        assert run.plan.sweep is not None
        RUNS[kind] = run, tone_result(run.blocks, run.phases, run.plan.sweep)
    return RUNS[kind]


def test_the_stretches_come_in_order_and_the_hand_is_given_back() -> None:
    run, result = ran("healthy")
    stretches = [key for key in run.sequence() if key[0] == "stretch"]
    assert stretches == [("stretch", index, "robot") for index in range(len(SPEEDS))]
    assert run.end.completed
    assert run.end.reason == "sweep"
    assert result.verdict == ""
    assert run.events == []


def test_fingers_reach_the_speed_that_was_asked_for_and_the_thumb_is_left_alone() -> None:
    _, result = ran("healthy")
    asked = np.array(SPEEDS)[:, None] * np.ones(int(FINGERS.sum()))
    assert result.reached_rad_s[:, FINGERS] == pytest.approx(asked, rel=0.1)
    assert np.isnan(result.reached_rad_s[:, ~FINGERS]).all()


def test_only_a_spastic_hand_opposes_speed() -> None:
    spastic, healthy = ran("mas2")[1], ran("healthy")[1]
    for joint in (MCP, PIP):
        assert spastic.per_speed_low[joint] > 0.0
        assert spastic.per_speed_nms_rad[joint] > 3.0 * abs(healthy.per_speed_nms_rad[joint])
        assert spastic.resistance_nm[2, joint] > spastic.resistance_nm[0, joint]


def test_a_short_hand_opposes_but_hardly_the_more_when_it_is_fast() -> None:
    short, spastic = ran("contracture")[1], ran("mas2")[1]
    assert short.per_speed_nms_rad[MCP] < 0.5 * spastic.per_speed_nms_rad[MCP]


@pytest.mark.parametrize("kind", ["healthy", "mas2", "contracture"])
def test_range_speed_and_load_stay_within_their_bounds(kind: VirtualKind) -> None:
    assert_within_bounds(ran(kind)[0])


def test_at_the_shipped_speed_the_stiffest_hand_is_not_overloaded_either() -> None:
    assert_within_bounds(Run(plan("mas3", extension_deg_s=15.0)))


def assert_within_bounds(run: Run) -> None:
    limits = run.plan.limits
    q, rate = run.column("q_rad"), run.column("dq_command_rad_s")
    assert bool((q > limits.q_min_rad - 0.02).all() and (q < limits.q_max_rad + 0.02).all())
    assert (rate >= -limits.extension_speed_rad_s - 1e-9).all()
    assert (rate <= limits.flexion_speed_rad_s + 1e-9).all()
    assert (np.abs(run.column("tau_interaction_nm")) <= limits.tau_interaction_nm).all()


def test_where_the_limits_forbid_a_speed_the_hand_is_stretched_as_fast_as_it_may() -> None:
    slow = plan("healthy", extension_deg_s=30.0)
    run = Run(slow)
    assert slow.sweep is not None
    result = tone_result(run.blocks, run.phases, slow.sweep)
    assert np.rad2deg(result.reached_rad_s[2, MCP]) == pytest.approx(30.0, rel=0.1)
    assert np.rad2deg(np.abs(run.column("dq_command_rad_s")).max()) <= 30.0 + 1e-6


def test_it_is_rehearsed_like_every_run() -> None:
    certificate = rehearse(plan("healthy"))
    assert certificate.accepted
    assert certificate.simulated_s < ran("healthy")[0].end.simulated_s


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"stretch_rad_s": (0.1,)}, "1 speeds"),
        ({"start_rad": ()}, "0 starting angles"),
        ({"stretch_rad_s": (0.1, 0.1, 0.1, 1.7)}, "1.7 rad/s"),
        ({"stretch_rad_s": (0.1, 0.1, 0.1, float("nan"))}, "nan rad/s"),
    ],
)
def test_a_tone_test_that_cannot_be_is_a_sentence(changes: dict[str, object], sentence: str) -> None:
    sweep = plan("healthy").sweep
    assert sweep is not None
    with pytest.raises(Refused, match=sentence):
        replace(sweep, **changes)
    with pytest.raises(Refused, match="of kind range"):
        ToneTest(replace(plan("healthy"), sweep=replace(sweep, kind="range")), 0.001)
