"""The observer of passivity: silent while the loop is a spring and a damper, loud before it runs away."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.safety import kernels
from robot_iface.safety.passivity import LIMIT_J
from robot_iface.types import SafetyState


def energy_j(rig: Any) -> float:
    return float(rig.supervisor._inspection.envelope._work[kernels.ENERGY].max())


def glide(rigid: Any, multiple: float, delay_ticks: int, **hand: Any) -> tuple[Any, float]:
    """Two seconds of movement and rest on a hand whose commands arrive late; largest energy on the way."""
    rig = rigid.Rig(multiple=multiple, ramp_s=0.05, late_ticks=delay_ticks, **hand)
    rig.go_active()
    largest = 0.0
    for tick in range(2000):
        rig.speed = np.full(3, 0.3 if 200 < tick < 1200 else 0.0)
        rig.cycle()
        largest = max(largest, energy_j(rig))
        if rig.events():
            break
    return rig, largest


@pytest.mark.parametrize("delay_ticks", [0, 1, 2])
@pytest.mark.parametrize("multiple", [1.0, 3.0, 10.0])
def test_it_is_silent_at_every_gain_that_can_be_prescribed(
    rigid: Any, multiple: float, delay_ticks: int
) -> None:
    rig, largest = glide(rigid, multiple, delay_ticks)
    assert rig.causes() == []
    assert largest < 0.2 * LIMIT_J


@pytest.mark.parametrize("multiple", [3.0, 10.0])
def test_a_spasm_or_a_tremor_is_the_patients_energy_not_the_loops(rigid: Any, multiple: float) -> None:
    for effort in (lambda t_s: 0.2 * (0.5 < t_s < 0.7), lambda t_s: 0.04 * np.sin(2 * np.pi * 5 * t_s)):
        rig, largest = glide(rigid, multiple, 1, effort=effort)
        assert "passivity" not in rig.causes()
        assert largest < 0.2 * LIMIT_J


@pytest.mark.parametrize(
    ("multiple", "delay_ticks"), [(30.0, 5), (20.0, 5), (10.0, 8), (10.0, 10), (3.0, 15)]
)
def test_an_unstable_loop_yields_before_it_trips_by_speed(
    rigid: Any, multiple: float, delay_ticks: int
) -> None:
    """Ten times the shipped gains with 5 ticks of delay, and the like."""
    rig, _ = glide(rigid, multiple, delay_ticks)
    assert rig.causes() == ["passivity"]
    assert rig.supervisor.state is SafetyState.COMPLIANT
    event = rig.events()[0]
    assert (event.joint in rigid.NAMES, event.bound) == (True, LIMIT_J)
    assert event.value > LIMIT_J
    speeds = np.rad2deg(np.abs([state.dq_rad_s for state in rig.states]))
    assert speeds.max() < 100.0, "half of the speed trip"
    rig.run(500)
    assert np.abs(rig.states[-1].dq_rad_s).max() < 0.01, "and it comes to rest"


def test_a_torque_sensor_that_is_off_by_20_mnm_is_no_unstable_loop(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    rig.hand.corrupt = lambda state: dataclasses.replace(state, tau_nm=state.tau_nm + 0.02)
    rig.glide(0.5, 1.5)
    assert rig.causes() == []
    assert energy_j(rig) < 0.2 * LIMIT_J


@pytest.mark.parametrize("joint", range(3))
def test_the_energy_is_that_of_the_ideal_law_subtracted_by_hand(rigid: Any, joint: int) -> None:
    """One tick, computed apart: torque beyond the law's, times the way, less the damper's loss."""
    rig = rigid.Rig(ramp_s=0.02, multiple=3.0)
    rig.go_active()
    rig.run(300)
    law, before = rig.outcomes[-1].applied, rig.states[-1].q_rad[joint]
    moved, speed, torque = -2e-3, -0.4, 0.09

    def corrupt(state: Any) -> Any:
        changed = {
            name: getattr(state, name).copy() for name in ("q_rad", "q_second_rad", "dq_rad_s", "tau_nm")
        }
        changed["q_rad"][joint] = changed["q_second_rad"][joint] = before + moved
        changed["dq_rad_s"][joint], changed["tau_nm"][joint] = speed, -torque
        return dataclasses.replace(state, **changed)

    rig.hand.corrupt = corrupt
    slow = float(rig.supervisor._inspection.envelope._work[kernels.SLOW, joint])
    rig.cycle()
    stiffness, damping = law.stiffness_nm_rad[joint], law.damping_nms_rad[joint]
    ideal = stiffness * (law.q_rad[joint] - before - 0.5 * moved) - damping * speed + law.tau_ff_nm[joint]
    excess = -torque - ideal
    slow += (1.0 - np.exp(-1e-3 / 0.05)) * (excess - slow)
    gained = (excess - slow) * moved - damping * speed**2 * 1e-3
    assert gained > 0.0
    assert energy_j(rig) == pytest.approx(gained, rel=1e-6)
    assert rig.causes() == []


def test_it_begins_anew_after_every_enable(rigid: Any) -> None:
    rig, _ = glide(rigid, 3.0, 15)
    rig.hand.late_ticks = 0
    rig.run(300)
    rig.supervisor.reset(present=True)
    rig.run(300)
    rig.goal = rig.hand.q.copy()
    rig.speed = np.zeros(3)
    rig.supervisor.enable_edge()
    rig.run(200)
    assert rig.supervisor.state is SafetyState.ACTIVE
    assert energy_j(rig) < 0.05 * LIMIT_J
