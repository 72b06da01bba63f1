from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sessions.metrics.dose import dose_completed, prescribed_repetitions, time_in
from sessions.metrics.effort import Work, robot_share, work, work_share
from sessions.metrics.visibility import fit_residual, longest_gap, valid_share

T = np.arange(0.0, 6.0, 0.001)
ANGLE = (1 - np.cos(2 * np.pi * T / 3)) / 2
SPEED = np.gradient(ANGLE, 0.001)


def share(tau: np.ndarray) -> float:
    return robot_share([work(T, tau, SPEED)], float(np.sqrt(np.mean(tau**2))), 1.0).value


@settings(max_examples=25, deadline=None)
@given(st.floats(0.02, 0.6), st.floats(0.0, 0.05))
def test_a_passive_limb_leaves_all_work_to_the_robot(stiffness: float, damping: float) -> None:
    assert share(stiffness * ANGLE + damping * SPEED + 0.011) == pytest.approx(1.0, abs=0.03)


def test_no_gain_is_no_share() -> None:
    assert share(np.zeros(T.size)) == 0.0
    assert share(0.0002 * np.sin(T)) == 0.0


def test_below_the_floor_of_the_sensor_nobody_can_tell_who_worked() -> None:
    assert math.isnan(share(0.004 * np.sin(T)))


def test_a_patient_who_drags_the_robot_along_does_all_the_work() -> None:
    assert share(-0.05 * SPEED) == pytest.approx(0.0, abs=0.01)


def test_without_a_passive_curve_the_bounds_are_told() -> None:
    estimate = robot_share([work(T, 0.2 * ANGLE, SPEED)], 0.1, 1.0)
    assert estimate.interval == pytest.approx((0.5, 1.0), abs=0.01)
    assert "not separable" in estimate.reason


def test_the_formula_with_a_known_patient() -> None:
    assert work_share(0.1 * SPEED, np.zeros(T.size), SPEED).value == 1.0
    assert work_share(np.zeros(T.size), 0.1 * SPEED, SPEED).value == 0.0
    assert work_share(0.1 * SPEED, 0.3 * SPEED, SPEED).value == pytest.approx(0.25)
    assert work_share(0.1 * SPEED, -0.3 * SPEED, SPEED).value == 1.0  # resisting takes no part
    assert work_share(0 * SPEED, 0 * SPEED, SPEED).reason == "no work was done"


def test_nothing_moved_has_no_share() -> None:
    assert math.isnan(robot_share([Work(0, 0, 0)], 0.1, 0.01).value)
    assert work(T[:1], T[:1], T[:1]) == Work(0.0, 0.0, 0.0)


def test_a_gap_in_time_is_not_filled_with_work() -> None:
    late = np.where(T > 3.0, T + 100.0, T)
    whole, cut = work(T, SPEED, SPEED).robot_j, work(late, SPEED, SPEED).robot_j
    assert cut == pytest.approx(whole, rel=0.01)


def test_dose() -> None:
    t = np.array([0.0, 1.0, 3.0, 4.0])
    phase = np.array(["ramp", "move", "hold", "rest"])
    assert time_in(t, phase, ("move", "hold")).value == pytest.approx(3.0)
    assert time_in(t[:1], phase[:1], ("move",)).reason
    late = np.where(t > 2.0, t + 3600.0, t)
    seen = np.linspace(0.0, 4.0, 401)
    jumped = np.where(seen > 2.0, seen + 3600.0, seen)
    assert time_in(late, phase, ("move", "hold"), jumped).value == pytest.approx(3.0, abs=0.02)
    slow = np.array([0.0, 1.0, 31.0, 32.0])
    assert time_in(slow, phase, ("move", "hold"), np.linspace(0.0, 32.0, 3201)).value == pytest.approx(31.0)
    assert dose_completed(3, '{"repetitions": 4}').value == 0.75
    for silent in ("", "[]", "{", '{"repetitions": 0}', '{"repetitions": true}', '{"repetitions": "4"}'):
        assert prescribed_repetitions(silent) is None
        assert math.isnan(dose_completed(3, silent).value)


def test_visibility() -> None:
    t = np.arange(10) / 10
    seen = np.array([1, 1, 0, 0, 0, 1, 1, 1, 1, 0], dtype=bool)
    assert valid_share(seen).value == pytest.approx(0.6)
    assert longest_gap(t, seen).value == pytest.approx(0.3)
    assert longest_gap(t, np.zeros(10, dtype=bool)).value == pytest.approx(1.0)
    assert longest_gap(t, np.ones(10, dtype=bool)).value == pytest.approx(0.0)
    assert fit_residual(np.array([3.0, 4.0, np.nan])).value == pytest.approx(math.sqrt(12.5))
    assert fit_residual(np.array([np.nan])).reason
