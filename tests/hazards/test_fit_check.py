"""Hazards 7 and 13: misaligned axes, slipped straps, a sign or zero error after donning.

Small slow movements after donning find them before anything else moves, or say that they cannot.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Order, Pain, Reset, Rig, ScriptedInbox, Surroundings, perform
from robot_iface.runtime.sweep_fit import AMPLITUDE_RAD, SPEED_RAD_S
from robot_iface.runtime.sweep_fit_reading import FitResult, fit_result
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, Fault, SimulatedExoskeleton, device_capabilities
from robot_iface.types import (
    Float64,
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    SafetyEvent,
    SafetyState,
    Sweep,
    TickBlock,
    VirtualKind,
)

DEVICE = device_capabilities()
RECORDED = PatientTwin("healthy", stiffness_nm_rad=0.04)


class NeverPressed:
    def pressed(self) -> bool:
        return False


class Run:
    def __init__(
        self, twin: PatientTwin, faults: tuple[Fault, ...] = (), orders: tuple[tuple[float, Order], ...] = ()
    ) -> None:
        sweep = Sweep("fit", DRIVEN, twin.side, (), np.zeros((0, len(DRIVEN))))
        limits = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)
        plan = Plan("exoskeleton", None, Prescription("passive"), limits, twin, 1, "0", sweep=sweep)
        robot = SimulatedExoskeleton(twin, 1, faults)
        self.messages: list[Any] = []
        around = Surroundings(NeverPressed(), self.messages.append, ScriptedInbox(orders))
        self.plan, self.sweep = plan, sweep
        self.end = perform(
            plan, Rig(robot, SimulatedClock(DEVICE.period_ns, robot.advance), robot.patient), around
        )
        self.blocks = [m for m in self.messages if isinstance(m, TickBlock)]
        self.events = [m for m in self.messages if isinstance(m, SafetyEvent)]

    def result(self, usual_neutral_rad: Float64 | None = None) -> FitResult:
        phases = [m for m in self.messages if isinstance(m, PhaseChange)]
        recorded = self.plan.twin.stiffness_nm_rad
        return fit_result(self.blocks, phases, self.end, self.sweep, recorded, usual_neutral_rad)

    def column(self, name: str) -> Float64:
        return np.concatenate([getattr(block, name) for block in self.blocks])

    @property
    def moved_rad(self) -> float:
        q = self.column("q_rad")
        return float(np.abs(q - q[0]).max())


RUNS: dict[str, Run] = {}


def well_donned() -> Run:
    if "well" not in RUNS:
        RUNS["well"] = Run(RECORDED)
    return RUNS["well"]


def test_a_hand_that_fits_passes_and_is_hardly_loaded() -> None:
    run = well_donned()
    result = run.result()
    assert run.end.completed
    assert result.verdict == ""
    assert run.events == []
    mcp = [index for index, name in enumerate(DRIVEN) if name.endswith("mcp_flexion")]
    assert result.stiffness_nm_rad[mcp] == pytest.approx(np.full(5, 0.04), abs=0.004)
    assert bool((result.gain > 0.85).all())
    assert run.moved_rad < AMPLITUDE_RAD + 0.01
    assert np.abs(run.column("dq_command_rad_s")).max() <= SPEED_RAD_S + 1e-9
    share = np.abs(run.column("tau_interaction_nm")) / run.plan.limits.tau_interaction_nm
    assert share.max() < 0.1
    assert run.end.simulated_s < 30.0


@pytest.mark.parametrize("kind", ["flaccid", "mas3", "tremor", "contracture"])
def test_other_hands_that_fit_pass_too(kind: VirtualKind) -> None:
    run = Run(PatientTwin(kind))
    assert run.result().verdict == ""
    assert run.end.completed


def test_a_joint_that_counts_the_wrong_way_lets_go_within_three_degrees() -> None:
    run = Run(RECORDED, (Fault("wrong-sign", 0.0, joint="thumb_cmc_flexion"),))
    assert not run.end.completed
    assert run.end.reason.startswith("fit: thumb_cmc_flexion")
    assert "sign" in run.end.reason or "sensor" in run.end.reason
    assert run.result().verdict == run.end.reason.removeprefix("fit: ")
    assert run.moved_rad < np.deg2rad(3.0)
    assert [event.joint for event in run.events if event.cause == "fit-failed"] == ["thumb_cmc_flexion"]


def test_a_flexion_that_counts_the_wrong_way_is_not_even_enabled() -> None:
    with pytest.raises(Refused, match="index_mcp_flexion is at -25"):
        Run(RECORDED, (Fault("wrong-sign", 0.0, joint="index_mcp_flexion"),))


def test_a_torque_sensor_that_counts_the_wrong_way_is_found() -> None:
    run = Run(RECORDED, (Fault("wrong-sign-interaction", 0.0, joint="ring_pip"),))
    assert "ring_pip seems to push along" in run.end.reason
    assert not run.end.completed


def test_a_zero_error_of_15_degrees_cuts_power_in_its_tick() -> None:
    run = Run(RECORDED, (Fault("sensor-offset", 0.0, joint="ring_pip", size=float(np.deg2rad(15.0))),))
    assert run.end.state is SafetyState.CAT0
    assert run.events[0].cause == "sensors-differ"
    assert run.moved_rad < 1e-2
    assert "sensors-differ" in run.result().verdict


def test_a_small_difference_of_the_sensors_is_found_before_anything_moves() -> None:
    run = Run(RECORDED, (Fault("sensor-offset", 0.0, joint="ring_pip", size=float(np.deg2rad(3.0))),))
    assert "ring_pip has sensors that differ by 3.0°, bound 2.0°" in run.end.reason
    assert run.moved_rad < np.deg2rad(0.5)


def test_a_stuck_sensor_is_found() -> None:
    run = Run(RECORDED, (Fault("stuck", 0.0, joint="middle_pip"),))
    assert "middle_pip" in run.end.reason
    assert not run.end.completed


@pytest.mark.parametrize("offset_m", [0.010, -0.010])
def test_axes_10_mm_off_along_the_finger_are_found_against_the_record(offset_m: float) -> None:
    run = Run(replace(RECORDED, axis_offset_m=(offset_m, 0.0)))
    assert "bound 0.02 to 0.10 by the patient's record: align the axes" in run.end.reason
    assert not run.end.completed


def test_axes_10_mm_off_without_a_record_cannot_be_told_from_a_soft_hand() -> None:
    """What the check cannot find is written down in the hazard log, and here."""
    run = Run(PatientTwin("healthy", axis_offset_m=(0.010, 0.0)))
    assert run.end.reason == "sweep"


def test_a_strap_that_slips_during_the_check_is_found() -> None:
    run = Run(replace(RECORDED, strap_slip_rad=float(np.deg2rad(10.0)), slip_at_s=8.0))
    assert run.end.reason.startswith("fit: ")


def test_straps_that_slipped_before_are_found_by_the_neutral_posture_of_an_earlier_day() -> None:
    slipped = Run(replace(RECORDED, strap_slip_rad=float(np.deg2rad(10.0))))
    assert slipped.result().verdict == ""  # nothing in the device's own readings tells it
    usual = well_donned().result().neutral_rad
    assert "10° from its usual place, bound 8°" in slipped.result(usual).verdict
    assert well_donned().result(usual).verdict == ""


def test_pain_ends_the_check_and_it_does_not_count() -> None:
    run = Run(RECORDED, (), ((4.0, Pain()), (5.0, Reset())))
    assert not run.end.completed
    assert run.result().verdict != ""
