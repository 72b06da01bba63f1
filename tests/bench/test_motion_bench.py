"""Speed of the motion core: prints times, asserts only ratios that hold on any machine."""

from __future__ import annotations

import sys
import time

import mujoco
import numpy as np
import pytest

from robot_iface.build import open_rig
from robot_iface.kinematics import average_hand
from robot_iface.link import MotionClient
from robot_iface.runtime import ScriptedInbox, Surroundings, perform
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, build_model, device_capabilities, virtual_patient
from robot_iface.types import Mode, PatientTwin, Plan, Prescription, ReferencePath, SafetyEvent

pytestmark = pytest.mark.bench


class NeverPressed:
    def pressed(self) -> bool:
        return False


def plan(mode: Mode, repetitions: int, realtime: bool = False) -> Plan:
    t_s = np.linspace(0.0, 4.0, 121)
    closing = 0.5 - 0.5 * np.cos(np.pi * t_s / 2.0)
    path = ReferencePath(
        DRIVEN, t_s, np.deg2rad(10.0 + 30.0 * closing[:, None] * np.ones(12)), "0" * 64, "right"
    )
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad)
    order = Prescription(mode, 0.5, repetitions)
    return Plan("exoskeleton", path, order, limits, PatientTwin("weak"), 1, "0", realtime)


def bare_step_us() -> float:
    device = device_capabilities()
    hand = build_model(average_hand(), virtual_patient("weak"), device.q_min_rad, device.q_max_rad)
    state = mujoco.MjData(hand.model)
    begun = time.perf_counter()
    for _ in range(20_000):
        mujoco.mj_step(hand.model, state)
    return (time.perf_counter() - begun) / 20_000 * 1e6


@pytest.mark.parametrize("mode", ["passive", "assistive"])
def test_sixty_seconds_of_therapy_take_half_of_that_or_less(mode: Mode) -> None:
    ordered = plan(mode, 6)
    begun = time.perf_counter()
    end = perform(
        ordered, open_rig(ordered), Surroundings(NeverPressed(), lambda message: None, ScriptedInbox())
    )
    wall_s = time.perf_counter() - begun
    tick_us = wall_s / end.simulated_s * 1e3
    ratio = end.simulated_s / wall_s
    sys.stderr.write(
        f"\n{mode}: {tick_us:.0f} us a tick, {tick_us / bare_step_us():.1f} times a bare mj_step, "
        f"{ratio:.1f} times real time, 60 s in {60 / ratio:.1f} s\n"
    )
    assert end.completed
    assert ratio >= 2.0


def test_latency_of_the_stop() -> None:
    ordered = plan("passive", 1)
    latencies_us: list[float] = []
    with MotionClient() as client:
        certificate = client.rehearse(ordered)
        for count in range(10):
            client.start(plan("passive", 1, realtime=True), certificate)
            for heard, message in enumerate(client.messages()):
                if heard == 8 + count:
                    client.press_stop()
                if isinstance(message, SafetyEvent):
                    assert message.cause == "e-stop"
            latency_ns = client.stop_latency_ns()
            assert latency_ns is not None
            latencies_us.append(latency_ns / 1000)
            client.reset()
    p50, p99 = np.percentile(latencies_us, [50, 99])
    sys.stderr.write(f"\npress of the stop to the latched tick: p50 {p50:.0f} us, p99 {p99:.0f} us\n")
