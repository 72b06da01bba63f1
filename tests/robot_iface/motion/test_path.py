from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.motion import PathPlayer, QuinticPath, check_path
from robot_iface.safety import shipped_limits
from robot_iface.types import ReferencePath

NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
PERIOD_S = 1e-3


def reference(seed: int = 1, knots: int = 201, duration_s: float = 4.0) -> ReferencePath:
    """A smooth closing and opening of three joints with uneven knots."""
    rng = np.random.default_rng(seed)
    t_s = np.linspace(0.0, duration_s, knots) + np.r_[0.0, rng.uniform(-0.3, 0.3, knots - 2), 0.0] * (
        duration_s / knots
    )
    phase = 2 * np.pi * t_s[:, None] / duration_s
    q = 0.6 - 0.4 * np.cos(phase) * np.array([1.0, 0.8, 0.5])
    return ReferencePath(NAMES, t_s, q, "digest", "right")


def test_every_knot_is_met() -> None:
    source = reference()
    path = QuinticPath(source)
    met = np.array([path.evaluate(float(s), 0.0, 0.0).q_rad for s in source.t_s])
    assert np.abs(met - source.q_rad).max() < 1e-12
    assert np.abs(path.sample(source.t_s) - source.q_rad).max() < 1e-12


def test_path_is_close_to_what_it_was_made_from_between_knots() -> None:
    path = QuinticPath(reference())
    s = np.linspace(0.2, 3.8, 5000)
    truth = 0.6 - 0.4 * np.cos(2 * np.pi * s[:, None] / 4.0) * np.array([1.0, 0.8, 0.5])
    assert np.abs(path.sample(s) - truth).max() < 1e-8
    assert np.abs(path.sample(s, 1)[:, 0] - 0.4 * np.pi / 2 * np.sin(np.pi / 2 * s)).max() < 1e-6


def test_derivatives_up_to_the_fourth_are_continuous_at_the_knots() -> None:
    source = reference()
    path = QuinticPath(source)
    for order, bound in ((0, 1e-9), (1, 1e-7), (2, 1e-6), (3, 1e-4), (4, 1e-2)):
        before = path.sample(source.t_s[1:-1] - 1e-9, order)
        after = path.sample(source.t_s[1:-1], order)
        assert np.abs(after - before).max() < bound, f"derivative {order}"


@given(
    s=st.floats(0.01, 3.99),
    speed=st.floats(0.0, 1.0),
    acceleration=st.floats(-2.0, 2.0),
)
@settings(max_examples=60, deadline=None)
def test_velocity_and_acceleration_are_those_of_the_moving_point(
    s: float, speed: float, acceleration: float
) -> None:
    path = QuinticPath(reference())
    h = 1e-4
    points = [path.evaluate(s + speed * t + 0.5 * acceleration * t * t, 0.0, 0.0).q_rad for t in (-h, 0.0, h)]
    here = path.evaluate(s, speed, acceleration)
    assert np.allclose((points[2] - points[0]) / (2 * h), here.dq_rad_s, atol=1e-5)
    assert np.allclose((points[2] - 2 * points[1] + points[0]) / h**2, here.ddq_rad_s2, atol=1e-3)


def test_coordinates_outside_the_path_stay_at_its_ends() -> None:
    source = reference()
    path = QuinticPath(source)
    assert np.allclose(path.evaluate(-1.0, 0.0, 0.0).q_rad, source.q_rad[0])
    assert np.allclose(path.evaluate(99.0, 0.0, 0.0).q_rad, source.q_rad[-1])
    assert np.allclose(path.start_rad(), source.q_rad[0])
    assert np.allclose(path.end_rad(), source.q_rad[-1])


@pytest.mark.parametrize("speed", [0.25, 0.5, 1.0])
def test_the_geometry_is_exact_at_any_speed(speed: float) -> None:
    """Every commanded point lies on the path at its own coordinate, and the whole path is travelled."""
    source = reference()
    path = QuinticPath(source)
    player = PathPlayer(path.duration_s, PERIOD_S, speed)
    states = []
    while not states or not states[-1].at_end:
        states.append(player.step())
        assert len(states) < 60_000
    points = np.array([path.evaluate(state.s, state.s_dot, state.s_ddot).q_rad for state in states])
    assert np.abs(points - path.sample(np.array([state.s for state in states]))).max() < 1e-12
    assert np.allclose(points[-1], source.q_rad[-1], atol=1e-12)
    assert np.abs(points.max(axis=0) - source.q_rad.max(axis=0)).max() < 1e-3
    assert np.diff([state.s for state in states]).max() <= speed * PERIOD_S + 1e-12


def limits(spastic: bool = False):
    return shipped_limits(NAMES, np.zeros(3), np.full(3, 1.5), spastic=spastic)


def test_a_path_within_the_limits_passes() -> None:
    assert check_path(QuinticPath(reference()), limits(), 0.5, PERIOD_S) is None


def test_too_fast_into_extension_is_named_with_joint_time_value_and_bound() -> None:
    """q' = 0.4 (2 pi / 4) sin: into extension after half the path, 36 deg/s at full speed, bound 30."""
    found = check_path(QuinticPath(reference()), limits(), 1.0, PERIOD_S)
    assert found is not None
    assert (found.joint, found.quantity) == ("index_mcp_flexion", "extension speed")
    crossing_s = 2.0 + np.arcsin(np.deg2rad(30.0) / (0.4 * np.pi / 2)) * 4.0 / (2 * np.pi)
    assert found.t_s == pytest.approx(crossing_s, abs=2e-3)
    assert found.bound == pytest.approx(np.deg2rad(30.0))
    assert found.value == pytest.approx(found.bound, rel=1e-2)
    assert "index_mcp_flexion extension speed is 30.0°/s at 2.6" in found.sentence()


def test_speed_is_checked_at_the_speed_that_will_be_played() -> None:
    path = QuinticPath(reference())
    assert check_path(path, limits(spastic=True), 0.4, PERIOD_S) is None
    slow = check_path(path, limits(spastic=True), 0.5, PERIOD_S)
    assert slow is not None
    assert slow.quantity == "extension speed"
    assert slow.t_s > 4.0


@pytest.mark.parametrize(("sign", "bound_deg"), [(1.0, 50.0), (-1.0, 20.0)])
def test_range_is_checked_on_both_sides_also_between_knots(sign: float, bound_deg: float) -> None:
    """Six knots: the extreme lies between two of them and is found there."""
    t_s = np.linspace(0.0, 5.0, 6)
    q = 0.6 + sign * 0.3 * np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0])[:, None] * np.ones(3)
    path = QuinticPath(ReferencePath(NAMES, t_s, q, "digest", "right"))
    peak = float((sign * path.sample(np.linspace(0.0, 5.0, 5001))).max())
    assert peak > float((sign * q).max()) + 0.01
    between = np.full(3, 0.5 * (peak + float((sign * q).max())))
    low, high = (np.zeros(3), between) if sign > 0 else (-between, np.full(3, 1.5))
    found = check_path(path, shipped_limits(NAMES, low, high, hyperextension=True), 0.2, PERIOD_S)
    assert found is not None
    assert found.quantity == "angle"
    assert 2.0 < found.t_s * 0.2 < 3.0
