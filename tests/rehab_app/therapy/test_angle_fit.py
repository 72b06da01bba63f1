from __future__ import annotations

import numpy as np

from rehab_app.therapy.angle_fit import fit_angles
from robot_iface.kinematics import average_hand
from sessions.records import JOINTS
from sessions.records.fields import Float64

HAND = average_hand()
T_S = np.arange(0.0, 6.0, 1.0 / 30.0)
GRID_S = np.linspace(0.0, T_S[-1], 299)
MCP, PIP = JOINTS.index("index_mcp_flexion"), JOINTS.index("index_pip")


def closing(hz: float = 0.25, t_s: Float64 = T_S) -> Float64:
    joints = np.zeros((t_s.size, 21))
    for row, name in enumerate(JOINTS):
        if name.endswith(("mcp_flexion", "pip", "dip")):
            joints[:, row] = 0.1 + 0.4 * (1.0 - np.cos(2.0 * np.pi * hz * t_s))
    return joints


def covariance(std_rad: float, correlation: float = 0.0) -> Float64:
    one = std_rad**2 * np.eye(21)
    one[MCP, PIP] = one[PIP, MCP] = correlation * std_rad**2
    return np.tile(one, (T_S.size, 1, 1))


def fit(joints: Float64, spread: Float64, **options: float | None) -> Float64:
    return fit_angles(T_S, joints, spread, HAND, GRID_S, at_rest=False, **options)


def error(path: Float64, truth: Float64) -> float:
    read = np.stack([np.interp(T_S, GRID_S, column) for column in path.T], axis=1)
    return float(np.sqrt(np.mean((read - truth) ** 2)))


def test_noise_goes_and_the_movement_stays() -> None:
    std = np.deg2rad(2.0)
    for hz in (0.25, 1.5):
        truth = closing(hz)
        noisy = truth + std * np.random.default_rng(1).standard_normal(truth.shape)
        assert error(fit(noisy, covariance(std)), truth) < 0.55 * std


def test_a_quick_movement_is_not_flattened_as_by_a_fixed_smoothness() -> None:
    std = np.deg2rad(1.0)
    truth = closing(2.0)
    noisy = truth + std * np.random.default_rng(2).standard_normal(truth.shape)
    found, fixed = fit(noisy, covariance(std)), fit(noisy, covariance(std), jerk_rad_s3=20.0)
    assert error(found, truth) < 0.3 * error(fixed, truth)


def test_what_two_joints_say_together_is_kept() -> None:
    """Oracle: MCP and PIP err against each other, their sum is sure: the path keeps the sum."""
    rng = np.random.default_rng(3)
    truth, std = closing(), np.deg2rad(4.0)
    noisy = truth.copy()
    wrong = std * rng.standard_normal(T_S.size)
    noisy[:, MCP] += wrong
    noisy[:, PIP] -= wrong
    sure = fit(noisy, covariance(std, -0.999), jerk_rad_s3=200.0)
    blind = fit(noisy, covariance(std), jerk_rad_s3=200.0)
    total = truth[:, MCP] + truth[:, PIP]

    def off(path: Float64) -> float:
        return float(np.abs(np.interp(T_S, GRID_S, path[:, MCP] + path[:, PIP]) - total).max())

    assert off(sure) < np.deg2rad(0.3)
    assert off(sure) <= off(blind) + 1e-6


def test_a_wrong_posture_does_not_pull() -> None:
    truth = closing()
    swapped = truth.copy()
    swapped[80:84, 5:9] += 1.0
    path = fit(swapped, covariance(np.deg2rad(1.0)))
    assert np.abs(path[:, PIP] - np.interp(GRID_S, T_S, truth[:, PIP])).max() < np.deg2rad(4.0)


def test_gaps_are_bridged_joint_by_joint_and_do_not_run_away() -> None:
    truth = closing()
    holed = truth.copy()
    holed[60:78, 5:9] = np.nan
    holed[100:160, PIP] = np.nan
    holed[:, 0] = np.nan
    path = fit(holed, covariance(np.deg2rad(1.0)))
    wanted = np.interp(GRID_S, T_S, truth[:, MCP])
    assert np.abs(path[:, MCP] - wanted).max() < np.deg2rad(3.0)
    assert -0.3 < path[:, PIP].min() < path[:, PIP].max() < 1.4
    np.testing.assert_array_equal(path[:, 0], 0.0)


def test_the_sure_posture_wins() -> None:
    truth = closing()
    often = np.arange(T_S.size) % 2 == 0
    joints = np.where(often[:, None], truth, truth + 0.4)
    spread = covariance(0.01)
    spread[~often] *= 50.0**2
    path = fit(joints, spread)
    assert error(path, truth) < np.deg2rad(1.0)


def test_uneven_samples() -> None:
    t_s = np.sort(np.random.default_rng(4).uniform(0.0, T_S[-1], 150))
    spread = np.tile(0.01**2 * np.eye(21), (t_s.size, 1, 1))
    path = fit_angles(t_s, closing(0.25, t_s), spread, HAND, GRID_S, at_rest=False)
    wanted = np.interp(GRID_S, T_S, closing()[:, PIP])
    assert np.abs(path[:, PIP] - wanted)[20:-20].max() < np.deg2rad(1.0)
