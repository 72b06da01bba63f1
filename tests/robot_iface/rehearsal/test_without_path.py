"""Runs without a path are rehearsed against their envelope, sweeps on the twin, devices on their own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from robot_iface.control import Goal, ImpedanceLaw, thesis_gains
from robot_iface.errors import Refused
from robot_iface.rehearsal import envelope, rehearse
from robot_iface.rehearsal.envelope import first_driven
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities, simulated_capabilities
from robot_iface.types import (
    Certificate,
    DeviceCommand,
    DeviceState,
    Hull,
    Mode,
    PatientTwin,
    Plan,
    Prescription,
    ReferencePath,
    Sweep,
)

MakePlan = Callable[..., Plan]
DEVICE = device_capabilities()
LIMITS = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)


def sweep_plan(
    kind: Literal["range", "fit"] = "range", twin: PatientTwin | None = None, **changes: Any
) -> Plan:
    goals = np.zeros((1, len(DRIVEN))) if kind == "range" else np.zeros((0, len(DRIVEN)))
    names = ("open",) if kind == "range" else ()
    sweep = Sweep(kind, DRIVEN, "right", names, goals, speed_rad_s=0.3)
    return Plan(
        "exoskeleton",
        None,
        Prescription("transparent"),
        changes.pop("limits", LIMITS),
        twin or PatientTwin("mas2"),
        1,
        "0",
        sweep=sweep,
        **changes,
    )


def test_a_range_sweep_is_rehearsed_on_the_twin() -> None:
    certificate = rehearse(sweep_plan())
    assert certificate.accepted
    assert "within every bound: highest load" in certificate.summary
    assert certificate.simulated_s > 5.0
    assert certificate.parts[1].startswith("sweep:")


def test_a_fit_check_is_rehearsed_on_a_hand_that_fits() -> None:
    slipped = PatientTwin("healthy", strap_slip_rad=0.17, slip_at_s=8.0, stiffness_nm_rad=0.04)
    assert rehearse(sweep_plan("fit", slipped)).accepted


@pytest.mark.parametrize("mode", ["transparent", "resistive"])
def test_modes_in_which_the_patient_moves_pass_within_the_envelope(
    make_plan: MakePlan, fist: Any, mode: Mode
) -> None:
    plan = make_plan(mode=mode, path=fist(1.0, 6.0, 20.0))
    assert first_driven(plan, DEVICE) == ""
    assert rehearse(plan).accepted


class Driving:
    """A law that helps with more than the patient gives, or with more torque than the patient may bear."""

    def __init__(self, share: float, torque_nm: float) -> None:
        self._share, self._torque_nm = share, torque_nm

    def command(self, state: DeviceState, goal: Goal, ramp: float, seq: int) -> DeviceCommand:
        inner = ImpedanceLaw(thesis_gains(DRIVEN), LIMITS).command(state, goal, ramp, seq)
        tau = -self._share * state.tau_interaction_nm + self._torque_nm
        return replace(inner, tau_ff_nm=tau)


@pytest.mark.parametrize(
    ("share", "torque_nm", "unit"), [(0.98, 0.0, "W"), (0.0, 0.3, "Nm"), (-0.5, 0.0, "W")]
)
def test_a_law_that_drives_is_refused_with_joint_value_and_bound(
    make_plan: MakePlan, monkeypatch: pytest.MonkeyPatch, share: float, torque_nm: float, unit: str
) -> None:
    monkeypatch.setattr(envelope, "make_law", lambda plan, device: Driving(share, torque_nm))
    monkeypatch.setattr(envelope, "_SETTLED_TICKS", 2)
    certificate = rehearse(make_plan(mode="transparent"))
    assert not certificate.accepted
    assert any(name in certificate.summary for name in DRIVEN)
    assert f" {unit}, bound" in certificate.summary
    assert certificate.simulated_s == 0.0


def test_a_path_that_leaves_the_common_range_is_not_accepted(make_plan: MakePlan, fist: Any) -> None:
    corners = np.deg2rad([[0.0, 0.0], [90.0, 0.0], [90.0, 20.0], [0.0, 20.0]])
    hull = Hull(("ring_mcp_flexion", "ring_pip"), corners)
    plan = make_plan(path=fist(4.0, 22.0, 8.0))
    certificate = rehearse(replace(plan, limits=replace(plan.limits, hulls=(hull,))))
    assert not certificate.accepted
    assert "ring_mcp_flexion and ring_pip common range" in certificate.summary
    assert "measure today's range again" in certificate.summary


def test_a_fist_that_comes_too_near_the_palm_is_not_accepted(make_plan: MakePlan) -> None:
    t_s = np.linspace(0.0, 12.0, 121)
    u = t_s / 12.0
    close = (u**3 * (10.0 - 15.0 * u + 6.0 * u * u))[:, None]
    goal = np.array([4.0 if "thumb" in name else 100.0 if name.endswith("pip") else 88.0 for name in DRIVEN])
    path = ReferencePath(DRIVEN, t_s, np.deg2rad(4.0 + close * (goal - 4.0)), "0" * 64, "right")
    certificate = rehearse(make_plan(path=path))
    assert not certificate.accepted
    assert "tip to palm clearance is" in certificate.summary
    assert "bound 5.0 mm" in certificate.summary


@pytest.mark.parametrize("measured", ["expired", "wrist"])
def test_limits_that_do_not_hold_now_are_refused_before_any_dry_run(measured: str) -> None:
    old = replace(LIMITS, measured_utc_ns=1, expires_utc_ns=2, wrist_rad=0.0)
    turned = replace(LIMITS, wrist_rad=float(np.deg2rad(30.0)))
    with pytest.raises(Refused, match=r"expired since 1970|wrist is at 0 degrees"):
        rehearse(sweep_plan(limits=old if measured == "expired" else turned))


def test_gains_that_are_out_of_bounds_are_refused(make_plan: MakePlan) -> None:
    plan = make_plan()
    soft = replace(plan.prescription, space="fingertip", stiffness_multiple=9.0)
    with pytest.raises(Refused, match="fingertip stiffness"):
        rehearse(replace(plan, prescription=soft))


def test_a_hand_that_is_not_worn_is_rehearsed_on_its_own_simulation() -> None:
    device = simulated_capabilities("dlr-hit-ii")
    t_s = np.linspace(0.0, 8.0, 81)
    u = np.minimum(t_s / 4.0, 2.0 - t_s / 4.0)
    close = (u**3 * (10.0 - 15.0 * u + 6.0 * u * u))[:, None]
    q = np.deg2rad(5.0 + 25.0 * close) * np.ones(len(device.joint_names))
    q = np.clip(q, device.q_min_rad + 0.02, device.q_max_rad - 0.02)
    path = ReferencePath(device.joint_names, t_s, q, "0" * 64, "right")
    limits = shipped_limits(device.joint_names, device.q_min_rad, device.q_max_rad)
    plan = Plan("dlr-hit-ii", path, Prescription("passive", repetitions=1), limits, PatientTwin(), 1, "0")
    certificate = rehearse(plan)
    assert certificate.accepted, certificate.summary


def test_warm_up_is_rehearsed_over_the_whole_range(make_plan: MakePlan, fist: Any) -> None:
    """A warm-up narrows the first repetitions; what the rehearsal must see is what comes after it."""
    plan = make_plan(path=fist(2.0, 20.0, 8.0), repetitions=8)
    whole = rehearse(plan)
    warmed = rehearse(replace(plan, prescription=replace(plan.prescription, warm_up_repetitions=5)))
    assert isinstance(warmed, Certificate)
    assert warmed.peak_interaction_nm == whole.peak_interaction_nm
