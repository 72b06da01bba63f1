"""Hazard 14, the part of the motion core: stop works in every state and whatever else is wrong, and stays."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.safety import Supervisor, Watch, shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton
from robot_iface.types import CommandMode, DeviceCommand, PatientTwin, SafetyState, VirtualKind

SITUATIONS = {
    "ready": lambda rig: None,
    "ramp-in": lambda rig: (rig.supervisor.enable_edge(), rig.run(100)),
    "active": lambda rig: (rig.supervisor.enable_edge(), rig.run(1100)),
    "hold": lambda rig: (rig.supervisor.enable_edge(), rig.run(1100), rig.run(1, enable_held=False)),
    "compliant": lambda rig: (rig.supervisor.enable_edge(), rig.run(1100), load(rig), rig.run(1)),
}


def load(rig: Any) -> None:
    rig.hand.corrupt = lambda state: dataclasses.replace(state, tau_interaction_nm=np.full(3, 0.4))


@pytest.mark.parametrize("situation", SITUATIONS)
def test_stop_acts_in_its_tick_and_stays_until_a_reset(rigid: Any, situation: str) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    rig.run(3)
    SITUATIONS[situation](rig)
    was_powered = rig.supervisor.powered
    rig.button.down = True
    outcome = rig.cycle()
    assert outcome.safety_state is SafetyState.CAT1
    assert rig.causes()[-1] == "e-stop"
    assert rig.hand.mode == ("brake" if was_powered else "off")
    rig.button.down = False
    rests_s = 3.2 if situation == "compliant" else 0.5  # the load that made it yield may have been a spasm
    rig.hand.corrupt = lambda state: state
    assert rig.run(round(rests_s / rigid.PERIOD_S)).safety_state is SafetyState.CAT1
    assert rig.hand.mode == "off"


def held_open(kind: VirtualKind, stop: Any) -> tuple[Any, Any]:
    """The fingers of a hand in the simulated exoskeleton, opened with 0.9 of the limit and held."""
    robot = SimulatedExoskeleton(PatientTwin(kind), 1)
    device = robot.capabilities
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad, spastic=True)
    supervisor = Supervisor(robot, limits, stop, device.period_ns, ramp_s=0.05)
    opens = np.array([not name.startswith("thumb") for name in DRIVEN]) * -0.9 * limits.tau_interaction_nm
    zeros = np.zeros(len(DRIVEN))
    supervisor.start()
    for tick in range(2500):
        robot.advance()
        supervisor.read(robot.read().t_ns)
        if tick == 2:
            supervisor.enable_edge()
        torque = opens * min(tick / 1500.0, 1.0)
        request = DeviceCommand(CommandMode.IMPEDANCE, zeros, zeros, torque, zeros, zeros + 0.05, tick)
        supervisor.write(request, Watch())
    assert supervisor.state is SafetyState.ACTIVE
    return robot, supervisor


def snap_rad_s(robot: Any, ticks: int) -> float:
    """Highest speed of the true hand in its first swing."""
    peak = 0.0
    for _ in range(ticks):
        robot.advance()
        peak = max(peak, float(np.abs(robot.hand_speed_rad_s).max()))
    return peak


@pytest.mark.parametrize("kind", ["mas2", "mas3", "contracture"])
def test_a_held_open_stiff_hand_meets_a_stop_at_a_quarter_of_the_speed_of_power_off(
    rigid: Any, kind: VirtualKind
) -> None:
    """On the whole exoskeleton, with strap and reflexes; of power off only the first swing counts."""
    button = rigid.Button()
    robot, supervisor = held_open(kind, button)
    button.down = True
    supervisor.read(robot.read().t_ns)
    outcome = supervisor.write(DeviceCommand(CommandMode.IMPEDANCE, *[np.zeros(12)] * 5, 0), Watch())
    assert outcome.safety_state is SafetyState.CAT1
    braked = snap_rad_s(robot, 600)
    robot, _ = held_open(kind, rigid.Button())
    robot.power_off()
    assert braked <= 0.25 * snap_rad_s(robot, 70)
