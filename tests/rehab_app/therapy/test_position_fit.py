from __future__ import annotations

import numpy as np
import pytest

from rehab_app.therapy.position_fit import PositionFit, fit_positions
from robot_iface.kinematics import (
    JOINT_MAX_RAD,
    JOINT_MIN_RAD,
    HandGeometry,
    average_hand,
    couple_dip,
    forward,
)
from sessions.errors import Refused
from sessions.records import DIGITS, FINGERS, JOINTS, LANDMARKS
from sessions.records.fields import Float64
from tests.bench.motion.fit import fit_row
from tests.bench.motion.fit_movements import draw

HAND = average_hand()
T_S = np.arange(0.0, 6.0, 1.0 / 30.0)
GRID_S = np.linspace(0.0, T_S[-1], 299)
FLEXIONS = [row for row, name in enumerate(JOINTS) if name.endswith(("mcp_flexion", "pip", "_ip", "dip"))]
NO_TIP = [row for row, name in enumerate(LANDMARKS) if not name.endswith("_tip")]
TUNING_SEED = 1


def closing() -> Float64:
    """Fingers and thumb that close and open once, shape (N, 21)."""
    joints = np.zeros((T_S.size, 21))
    closed = 0.5 * (1.0 - np.cos(2.0 * np.pi * T_S / 6.0))
    for row, name in enumerate(JOINTS):
        if name.endswith(("mcp_flexion", "pip", "_ip")):
            joints[:, row] = 0.15 + (0.5 if name.startswith("thumb") else 1.0) * closed
    return couple_dip(joints)


def seen(geometry: HandGeometry = HAND, noise_m: float = 0.0, seed: int = 2) -> Float64:
    marks = forward(geometry, closing()).landmarks_m
    return marks + noise_m * np.random.default_rng(seed).standard_normal(marks.shape)


def error(fit: PositionFit, columns: list[int], grid_s: Float64 = GRID_S) -> float:
    read = np.stack([np.interp(T_S, grid_s, fit.joints_rad[:, column]) for column in columns], axis=1)
    return float(np.rad2deg(np.sqrt(np.mean((read - closing()[:, columns]) ** 2))))


def test_perfect_landmarks_give_the_movement_back() -> None:
    fit = fit_positions(T_S, seen(), HAND, GRID_S)
    assert error(fit, FLEXIONS) < 0.35
    assert fit.rejected == 0
    assert (fit.std_m < 5e-4).all()


def test_fingertips_alone_will_do() -> None:
    tips = seen(noise_m=1e-3)
    tips[:, NO_TIP] = np.nan
    fingers = [JOINTS.index(f"{finger}_{joint}") for finger in FINGERS for joint in ("mcp_flexion", "pip")]
    assert error(fit_positions(T_S, tips, HAND, GRID_S), fingers) < 2.0


def test_the_noise_is_found_out() -> None:
    for noise_m in (1e-3, 3e-3):
        fit = fit_positions(T_S, seen(noise_m=noise_m), HAND, GRID_S)
        np.testing.assert_allclose(fit.std_m, noise_m, rtol=0.12)


def test_outliers_end_with_no_say() -> None:
    clean = seen(noise_m=1e-3)
    swapped = clean.copy()
    swapped[40:44, LANDMARKS.index("index_tip")] += 0.05
    swapped[100, LANDMARKS.index("ring_pip")] -= 0.04
    fit = fit_positions(T_S, swapped, HAND, GRID_S)
    assert fit.rejected >= 5
    assert error(fit, FLEXIONS) < error(fit_positions(T_S, clean, HAND, GRID_S), FLEXIONS) + 0.05


def test_a_gap_is_bridged_by_the_movement_around_it() -> None:
    marks = seen(noise_m=1e-3)
    marks[80:98, 4:8] = np.nan  # 0.6 s of the index finger
    fit = fit_positions(T_S, marks, HAND, GRID_S)
    inside = (GRID_S > T_S[80]) & (GRID_S < T_S[98])
    truth = np.interp(GRID_S, T_S, closing()[:, JOINTS.index("index_pip")])
    off = np.abs(fit.joints_rad[:, JOINTS.index("index_pip")] - truth)[inside]
    assert np.rad2deg(off.max()) < 3.0


def test_a_digit_never_seen_is_nan_and_the_others_are_as_before() -> None:
    marks = seen(noise_m=1e-3)
    whole = fit_positions(T_S, marks, HAND, GRID_S)
    marks[:, 8:12] = np.nan
    fit = fit_positions(T_S, marks, HAND, GRID_S)
    middle = [row for row, name in enumerate(JOINTS) if name.startswith("middle")]
    others = [row for row in range(21) if row not in middle]
    assert np.isnan(fit.joints_rad[:, middle]).all()
    assert np.isnan(fit.std_m[DIGITS.index("middle")])
    np.testing.assert_array_equal(fit.joints_rad[:, others], whole.joints_rad[:, others])


def test_both_sides_give_the_same_angles() -> None:
    """Hazard 1: a left hand's landmarks are a right hand's mirrored, and mean the same angles."""
    right = fit_positions(T_S, seen(average_hand(side="right")), average_hand(side="right"), GRID_S)
    left = fit_positions(T_S, seen(average_hand(side="left")), average_hand(side="left"), GRID_S)
    np.testing.assert_allclose(left.joints_rad, right.joints_rad, atol=1e-9)


def test_angles_stay_within_the_anatomy_and_rest_at_the_ends_when_asked() -> None:
    grid_s = np.linspace(-0.4, T_S[-1] + 0.4, 338)
    fit = fit_positions(T_S, seen(noise_m=3e-3), HAND, grid_s, at_rest=True)
    assert (fit.joints_rad >= JOINT_MIN_RAD).all()
    assert (fit.joints_rad <= JOINT_MAX_RAD).all()
    ends = np.diff(fit.joints_rad, axis=0)[[0, -1]] / (grid_s[1] - grid_s[0])
    assert np.abs(ends).max() < np.deg2rad(1.0)


def test_the_same_positions_give_the_same_bits() -> None:
    marks = seen(noise_m=2e-3)
    one, two = (fit_positions(T_S, marks, HAND, GRID_S).joints_rad for _ in range(2))
    np.testing.assert_array_equal(one, two)


def test_a_stated_smoothness_and_noise_are_kept() -> None:
    fit = fit_positions(T_S, seen(noise_m=1e-3), HAND, GRID_S, std_m=1.5e-3, jerk_rad_s3=30.0)
    np.testing.assert_array_equal(fit.std_m, 1.5e-3)
    np.testing.assert_array_equal(fit.jerk_rad_s3, 30.0)


@pytest.mark.parametrize("movement", ["fist", "tendon glides", "opposition"])
@pytest.mark.parametrize("sight", ["fingertips", "landmarks"])
def test_it_beats_filtering_first(sight: str, movement: str) -> None:
    """The figures are printed by the bench; here, on one seed, the bound that must hold."""
    assert fit_row(sight, movement, 2e-3, (TUNING_SEED,)).ratio < 0.7


def test_what_cannot_be_fitted_is_refused() -> None:
    with pytest.raises(Refused, match="25 landmarks"):
        fit_positions(T_S, np.zeros((T_S.size, 21, 3)), HAND, GRID_S)
    with pytest.raises(Refused, match="without any digit"):
        fit_positions(T_S, np.full((T_S.size, 25, 3), np.nan), HAND, GRID_S)
    with pytest.raises(Refused, match="widen the grid"):
        fit_positions(T_S, seen(), HAND, GRID_S[:200])


def test_the_drawn_movements_have_gaps_and_outliers() -> None:
    drawn = draw("fist", 1e-3, TUNING_SEED, tips_only=False)
    off = np.linalg.norm(drawn.seen_m - forward(drawn.geometry, drawn.joints_rad).landmarks_m, axis=2)
    assert 0.03 < np.isnan(off).mean() < 0.15
    assert 0.01 < np.nanmean(off > 0.015) < 0.03
