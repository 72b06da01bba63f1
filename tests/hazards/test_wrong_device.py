"""Hazard: a real device moves that nobody meant, or that nobody confirmed. Simulation is the default."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehab_app.services.order import Order
from robot_iface.build import capabilities, open_rig
from robot_iface.errors import Refused
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import PatientTwin, Plan, Prescription, ReferencePath

REAL = "ros2:clinic-hand"


def plan(device: str, confirmed: str, *, realtime: bool = True) -> Plan:
    own = device_capabilities()
    limits = shipped_limits(DRIVEN, own.q_min_rad, own.q_max_rad)
    t_s = np.linspace(0.0, 2.0, 41)
    path = ReferencePath(DRIVEN, t_s, np.full((41, len(DRIVEN)), 0.3), "0" * 64, "right")
    made = Plan(device, path, Prescription("passive"), limits, PatientTwin(), 1, "0")
    return replace(made, confirmed_device=confirmed, realtime=realtime)


def test_what_nobody_chose_is_simulated() -> None:
    assert capabilities(Order().device).simulated


@pytest.mark.parametrize(
    "confirmed", ["", "yes", "exoskeleton", "ros2:", "ros2:clinic", "ros2:clinic-hand2", "ROS2:CLINIC-HAND"]
)
def test_only_its_own_name_confirms_a_real_device(confirmed: str) -> None:
    with pytest.raises(Refused, match="confirm"):
        open_rig(plan(REAL, confirmed))


def test_a_confirmed_device_is_not_opened_on_simulated_time() -> None:
    with pytest.raises(Refused, match="simulated time"):
        open_rig(plan(REAL, REAL, realtime=False))


def test_a_confirmed_device_that_nobody_described_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("REHAB_DEVICES", str(tmp_path))
    with pytest.raises(Refused):
        open_rig(plan(REAL, REAL))
    assert list(tmp_path.iterdir()) == []
