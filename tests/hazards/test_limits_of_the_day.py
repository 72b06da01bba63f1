"""Hazard 12: old limits or another wrist angle. The motion core refuses them itself."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.build import open_rig
from robot_iface.errors import Refused
from robot_iface.rehearsal import rehearse
from robot_iface.runtime import ScriptedInbox, Surroundings, run
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import PatientTwin, Plan, Prescription, Sweep

DEVICE = device_capabilities()
MIDNIGHT_NS = 4_000_000_000_000_000_000
NOON_NS = MIDNIGHT_NS - 43_200_000_000_000
WRIST_RAD = float(np.deg2rad(20.0))


class NeverPressed:
    def pressed(self) -> bool:
        return False


class Clock:
    """The time of day that the motion core is told."""

    def __init__(self) -> None:
        self.now_ns = NOON_NS


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    ours = Clock()
    monkeypatch.setattr(time, "time_ns", lambda: ours.now_ns)
    return ours


def plan(wrist_rad: float = WRIST_RAD) -> Plan:
    limits = replace(
        shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad),
        measured_utc_ns=NOON_NS,
        expires_utc_ns=MIDNIGHT_NS,
        wrist_rad=WRIST_RAD,
    )
    sweep = Sweep("range", DRIVEN, "right", ("open",), np.full((1, len(DRIVEN)), 0.3), active=False)
    return Plan(
        *("exoskeleton", None, Prescription("passive"), limits, PatientTwin("flaccid"), 1, "0"),
        sweep=sweep,
        wrist_rad=wrist_rad,
    )


def start(wanted: Plan, certificate: Any) -> list[Any]:
    messages: list[Any] = []
    run(wanted, certificate, open_rig(wanted), Surroundings(NeverPressed(), messages.append, ScriptedInbox()))
    return messages


def test_limits_of_today_run_and_those_that_expired_since_the_rehearsal_do_not(clock: Clock) -> None:
    certificate = rehearse(plan())
    assert certificate.accepted
    assert start(plan(), certificate)[-1].completed
    clock.now_ns = MIDNIGHT_NS
    with pytest.raises(Refused, match="limits is expired since"):
        start(plan(), certificate)
    with pytest.raises(Refused, match="limits is expired since"):
        rehearse(plan())


def test_another_wrist_angle_is_refused_and_needs_its_own_rehearsal(clock: Clock) -> None:
    certificate = rehearse(plan())
    turned = plan(WRIST_RAD + float(np.deg2rad(9.0)))
    with pytest.raises(Refused, match="a different wrist angle"):
        start(turned, certificate)
    assert rehearse(turned).accepted
    with pytest.raises(Refused, match=r"wrist is at 31 degrees.*within 10 degrees of the measured 20"):
        rehearse(plan(WRIST_RAD + float(np.deg2rad(11.0))))
