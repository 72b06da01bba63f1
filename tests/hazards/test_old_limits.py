"""Hazard 12: limits of another day or wrist angle are refused, at planning and again at play."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.audit import Audit
from rehab_app.services.clinic import Clinic
from rehab_app.services.order import Order
from rehab_app.services.patient_limits import PatientLimits
from robot_iface.build import capabilities
from robot_iface.safety import shipped_limits

WRIST_RAD = float(np.deg2rad(20.0))
TODAY = Order(repetitions=1, wrist_rad=WRIST_RAD)


@pytest.fixture
def clinic(tmp_path) -> Iterator[Clinic]:
    with open_clinic(tmp_path / "clinic") as opened:
        recorded = opened.takes.record_virtual("open_close", "right", 3.0, 2, CONSOLE)
        opened.takes.approve(recorded.take, CONSOLE)
        opened.patients.add(CONSOLE, given_name="A", family_name="B", birth_date="1950-12-31", side="right")
        yield opened


def measure(clinic: Clinic, utc_ns: int | None = None) -> None:
    device = capabilities("exoskeleton")
    limits = shipped_limits(device.joint_names, device.q_min_rad, device.q_max_rad - 0.3)
    clock = {} if utc_ns is None else {"clock_ns": lambda: utc_ns}
    desk = PatientLimits(clinic.catalogue, Audit(clinic.catalogue), **clock)
    desk.keep(CONSOLE, clinic.catalogue.patient("P-0001"), device, limits, WRIST_RAD)


def plan(clinic: Clinic, order: Order = TODAY):
    return clinic.therapy.plan(clinic.takes.list()[0].id, order, actor=CONSOLE, patient_id="P-0001")


def test_today_and_at_this_wrist_angle_they_hold(clinic: Clinic) -> None:
    measure(clinic)
    prepared = plan(clinic)
    assert prepared.plan.limits.expires_utc_ns > prepared.plan.limits.measured_utc_ns > 0
    assert prepared.plan.limits.wrist_rad == prepared.plan.wrist_rad == WRIST_RAD
    assert any("measured by console" in note for note in prepared.notes)


def test_limits_of_another_day_are_refused_and_defaults_do_not_step_in(clinic: Clinic) -> None:
    measure(clinic, 1_750_000_000_000_000_000)
    with pytest.raises(Refused, match=r"expired.*limits measure"):
        plan(clinic)


@pytest.mark.parametrize("off_deg", [-45.0, -11.0, 11.0, 45.0])
def test_another_wrist_angle_is_refused(clinic: Clinic, off_deg: float) -> None:
    measure(clinic)
    with pytest.raises(Refused, match="wrist angle"):
        plan(clinic, replace(TODAY, wrist_rad=WRIST_RAD + float(np.deg2rad(off_deg))))


def test_limits_that_expire_between_plan_and_play_are_refused(clinic: Clinic) -> None:
    measure(clinic)
    prepared = plan(clinic)
    therapy = clinic.therapy
    therapy._clock_ns = lambda: prepared.plan.limits.expires_utc_ns
    with pytest.raises(REFUSALS, match="expired"):
        therapy.rehearse_and_play(prepared, actor=CONSOLE)
    assert clinic.sessions.list() == ()
