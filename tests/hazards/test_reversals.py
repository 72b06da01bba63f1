"""Hazard 3, over repetitions: loads that reverse the motion narrow the range, then end the run."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from robot_iface.motion import QuinticPath
from robot_iface.runtime.allowance import Allowance
from robot_iface.runtime.reversals import Reversals, Verdict
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import Float64, PatientTwin, Plan, Prescription, ReferencePath

JOINTS = len(DRIVEN)


def test_two_in_five_narrow_and_a_third_stops_whatever_the_order() -> None:
    """Every history of eight repetitions, against the rule written down plainly."""
    for history in itertools.product((False, True), repeat=8):
        reversals = Reversals()
        for place, flag in enumerate(history):
            seen = sum(history[max(place - 4, 0) : place + 1])
            verdict = reversals.note(reversed_on_load=flag)
            if not flag or seen < 2:
                assert verdict == Verdict.GO_ON
            else:
                assert verdict == (Verdict.NARROW if seen == 2 else Verdict.STOP)


def allowance() -> tuple[Allowance, Float64]:
    """A closing of all joints from 10 to 50 degrees and back; its postures."""
    t_s = np.linspace(0.0, 6.0, 121)
    closing = 0.5 - 0.5 * np.cos(2.0 * np.pi * t_s / 6.0)
    q = np.deg2rad(10.0 + 40.0 * closing[:, None] * np.ones(JOINTS))
    path = ReferencePath(DRIVEN, t_s, q, "0" * 64, "right")
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad)
    plan = Plan("exoskeleton", path, Prescription("passive"), limits, PatientTwin(), 1, "0")
    spline = QuinticPath(path)
    return Allowance(spline, plan), spline.sample(t_s)


@pytest.mark.parametrize(("direction", "expected"), [(1.0, (10.0, 45.0)), (-1.0, (15.0, 50.0))])
def test_five_degrees_are_taken_off_the_end_that_was_headed_for(
    direction: float, expected: tuple[float, float]
) -> None:
    allowed, postures = allowance()
    way = np.zeros(JOINTS)
    way[3] = direction
    allowed.cut(way)
    asked = np.rad2deg(allowed.for_repetition(2).apply(postures))
    assert (asked[:, 3].min(), asked[:, 3].max()) == pytest.approx(expected, abs=0.05)
    others = np.delete(asked, 3, axis=1)
    assert (others.min(), others.max()) == pytest.approx((10.0, 50.0), abs=0.05)


def test_cuts_add_up_and_never_widen() -> None:
    allowed, postures = allowance()
    spans = []
    for _ in range(4):
        spans.append(float(np.ptp(allowed.for_repetition(0).apply(postures)[:, 0])))
        allowed.cut(np.ones(JOINTS))
    assert np.rad2deg(np.diff(spans)) == pytest.approx(np.full(3, -5.0), abs=0.05)
