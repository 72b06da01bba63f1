"""Devices are chosen by name; a real one only by a person who confirms it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from robot_iface.build import DEVICES, capabilities, open_rig
from robot_iface.errors import Refused
from robot_iface.loop import PacedSimulatedClock, SimulatedClock
from robot_iface.sim import SimulatedDlrHit, SimulatedExoskeleton, simulated
from robot_iface.types import PatientTwin, Plan

MakePlan = Callable[..., Plan]


def test_every_device_has_capabilities_and_a_rig_of_its_own(make_plan: MakePlan) -> None:
    kinds = {"exoskeleton": SimulatedExoskeleton, "dlr-hit-ii": SimulatedDlrHit}
    assert set(DEVICES) == set(kinds)
    for device in DEVICES:
        rig = open_rig(replace(make_plan(), device=device))
        assert isinstance(rig.robot, kinds[device])
        assert isinstance(rig.clock, SimulatedClock)
        assert rig.robot.capabilities.simulated
        assert rig.robot.capabilities.joint_names == capabilities(device).joint_names
        rig.clock.wait_next_tick()
        assert rig.robot.read().seq == 1


def test_a_run_that_people_watch_keeps_pace_with_the_clock_on_the_wall(make_plan: MakePlan) -> None:
    rig = open_rig(replace(make_plan(), realtime=True))
    assert isinstance(rig.clock, PacedSimulatedClock)


@pytest.mark.parametrize("device", ["", "robot", "ros2:", "ROS2:hand"])
def test_an_unknown_device_is_refused_with_those_that_exist(make_plan: MakePlan, device: str) -> None:
    with pytest.raises(Refused, match=r"exoskeleton, dlr-hit-ii"):
        capabilities(device)
    with pytest.raises(Refused, match=r"exoskeleton, dlr-hit-ii"):
        open_rig(replace(make_plan(), device=device))
    with pytest.raises(Refused, match=r"exoskeleton, dlr-hit-ii"):
        simulated(device, PatientTwin(), 1)


@pytest.mark.parametrize("confirmed", ["", "exoskeleton", "ros2:other"])
def test_a_real_device_that_nobody_confirmed_is_refused(make_plan: MakePlan, confirmed: str) -> None:
    plan = replace(make_plan(), device="ros2:clinic-hand", confirmed_device=confirmed, realtime=True)
    with pytest.raises(Refused, match=r"confirm"):
        open_rig(plan)


def test_a_real_device_on_simulated_time_is_refused(make_plan: MakePlan) -> None:
    plan = replace(make_plan(), device="ros2:clinic-hand", confirmed_device="ros2:clinic-hand")
    with pytest.raises(Refused, match=r"simulated time"):
        open_rig(plan)


def test_a_real_device_without_a_file_is_refused(
    make_plan: MakePlan, monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    monkeypatch.setenv("REHAB_DEVICES", str(tmp_path))
    name = "ros2:nowhere"
    with pytest.raises(Refused):
        capabilities(name)
    with pytest.raises(Refused):
        open_rig(replace(make_plan(), device=name, confirmed_device=name, realtime=True))


def test_a_real_device_is_rehearsed_on_the_exoskeleton_with_the_same_patient() -> None:
    twin = PatientTwin("mas2", "left")
    robot, patient = simulated("ros2:clinic-hand", twin, 3)
    own, _ = simulated("exoskeleton", twin, 3)
    assert isinstance(robot, SimulatedExoskeleton)
    assert isinstance(own, SimulatedExoskeleton)
    assert patient is robot.patient
    for _ in range(10):
        robot.advance()
        own.advance()
    np.testing.assert_array_equal(robot.hand_rad, own.hand_rad)
