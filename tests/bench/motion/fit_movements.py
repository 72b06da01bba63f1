"""Movements with known angles, and what a marker camera would see of them: noise, gaps, outliers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.kinematics import DIP_PER_PIP, HandGeometry, average_hand, forward
from sessions.records import DIGITS, FINGERS, JOINTS, LANDMARKS
from sessions.records.fields import Float64

MOVEMENTS = ("fist", "tendon glides", "opposition", "tapping")
SECONDS = 12.0
_POSTURES_DEG = {  # MCP and PIP of the long fingers
    "straight": (2.0, 4.0),
    "hook": (5.0, 85.0),
    "fist": (78.0, 92.0),
    "tabletop": (72.0, 6.0),
    "straight fist": (75.0, 80.0),
}
_DIP_STRAY_RAD = np.deg2rad(8.0)


@dataclass(frozen=True, slots=True)
class Drawn:
    """A movement and what is seen of it.

    Attributes:
        geometry: The hand.
        t_s: Sample times, shape (N,).
        joints_rad: True angles, shape (N, 21).
        seen_m: Landmarks in the palm frame, NaN where unseen, shape (N, 25, 3).
    """

    geometry: HandGeometry
    t_s: Float64
    joints_rad: Float64
    seen_m: Float64


def draw(movement: str, noise_m: float, seed: int, rate_hz: float = 30.0, *, tips_only: bool) -> Drawn:
    """Draw a movement and its sight.

    Args:
        movement: One of MOVEMENTS.
        noise_m: Standard deviation of a position per axis.
        seed: Of everything random.
        rate_hz: Captures a second.
        tips_only: Only the fingertips are seen, and the DIP joints follow the PIP joints; otherwise all
            landmarks are seen and the DIP joints stray.
    """
    rng = np.random.default_rng([seed, MOVEMENTS.index(movement)])
    t_s = np.arange(0.0, SECONDS, 1.0 / rate_hz)
    joints = _angles(movement, t_s, rng)
    for finger in FINGERS:
        pip = JOINTS.index(f"{finger}_pip")
        joints[:, pip + 1] = DIP_PER_PIP * joints[:, pip]
        if not tips_only:
            joints[:, pip + 1] += _DIP_STRAY_RAD * _wander(t_s, rng)
    geometry = average_hand(float(rng.uniform(0.17, 0.205)))
    seen = forward(geometry, joints).landmarks_m
    seen = seen + noise_m * rng.standard_normal(seen.shape)
    strange = rng.random(seen.shape[:2]) < 0.02
    seen[strange] += rng.uniform(0.02, 0.06, (int(strange.sum()), 1)) * _directions(int(strange.sum()), rng)
    _hide(seen, t_s, rng)
    if tips_only:
        seen[:, [row for row, name in enumerate(LANDMARKS) if not name.endswith("_tip")]] = np.nan
    return Drawn(geometry, t_s, joints, seen)


def _hide(seen: Float64, t_s: Float64, rng: np.random.Generator) -> None:
    """Two gaps of 0.2 to 0.6 s in every digit, and lone frames here and there."""
    for digit in range(len(DIGITS)):
        for _ in range(2):
            start_s = rng.uniform(0.5, SECONDS - 1.5)
            gap = (t_s >= start_s) & (t_s < start_s + rng.uniform(0.2, 0.6))
            seen[gap, 4 * digit : 4 * digit + 4] = np.nan
    seen[rng.random(seen.shape[:2]) < 0.01] = np.nan


def _directions(count: int, rng: np.random.Generator) -> Float64:
    drawn = rng.standard_normal((count, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def _wander(t_s: Float64, rng: np.random.Generator) -> Float64:
    """A slow curve of about -1 to 1."""
    phase, hz = rng.uniform(0, 2 * np.pi, 2), rng.uniform(0.05, 0.3, 2)
    return 0.5 * (np.sin(2 * np.pi * hz[0] * t_s + phase[0]) + np.sin(2 * np.pi * hz[1] * t_s + phase[1]))


def _angles(movement: str, t_s: Float64, rng: np.random.Generator) -> Float64:
    joints = np.zeros((t_s.size, len(JOINTS)))
    for number, finger in enumerate(FINGERS):
        share, late_s = rng.uniform(0.9, 1.05), rng.uniform(-0.08, 0.08)
        mcp, pip = _finger(movement, number, t_s - late_s, np.random.default_rng(rng.integers(2**32)))
        column = JOINTS.index(f"{finger}_mcp_flexion")
        joints[:, column], joints[:, column + 2] = share * mcp, share * pip
        spread = np.deg2rad(rng.uniform(-8.0, 8.0))
        joints[:, column + 1] = spread * (1.0 - np.clip(mcp / 1.4, 0.0, 1.0)) + 0.03 * _wander(t_s, rng)
    joints[:, :5] = _thumb(movement, t_s, rng)
    return joints


def _finger(movement: str, number: int, t_s: Float64, rng: np.random.Generator) -> tuple[Float64, Float64]:
    if movement == "fist":
        period_s = 3.4 + 0.1 * number
        closed = 0.5 * (1.0 - np.cos(2 * np.pi * np.clip(t_s - 0.6, 0.0, 3 * period_s) / period_s))
        return np.deg2rad(3.0 + 75.0 * closed), np.deg2rad(4.0 + 90.0 * closed**1.2)
    if movement == "tendon glides":
        order = ("straight", "hook", "straight", "fist", "straight", "tabletop", "straight fist", "straight")
        stations = np.deg2rad([_POSTURES_DEG[name] for name in order])
        both = _stations(t_s, stations, move_s=0.8, hold_s=0.6)
        return both[:, 0], both[:, 1]
    if movement == "opposition":
        start_s = 0.8 + 2.7 * number
        touch = _bump(t_s, start_s, 2.2)
        return np.deg2rad(8.0 + 45.0 * touch), np.deg2rad(10.0 + 45.0 * touch)
    start_s, hz = 0.8 + 2.7 * number, rng.uniform(1.8, 2.6)
    tap = (
        0.5 * (1.0 - np.cos(2 * np.pi * hz * (t_s - start_s))) * ((t_s > start_s) & (t_s < start_s + 5 / hz))
    )
    return np.deg2rad(12.0 + 28.0 * tap), np.deg2rad(20.0 + 12.0 * tap)


def _thumb(movement: str, t_s: Float64, rng: np.random.Generator) -> Float64:
    late_s = rng.uniform(0.0, 0.2)
    if movement == "opposition":
        way = sum(_bump(t_s, 0.7 + late_s + 2.7 * number, 2.4) for number in range(4))
    elif movement == "fist":
        way = 0.5 * (1.0 - np.cos(2 * np.pi * np.clip(t_s - 1.0 - late_s, 0.0, 9.9) / 3.3))
    else:
        way = 0.4 + 0.2 * _wander(t_s, rng)
    start = np.deg2rad([-5.0, 5.0, 5.0, 0.0, 5.0])
    return start + np.asarray(way)[:, None] * np.deg2rad([30.0, 20.0, 35.0, 3.0, 40.0])


def _minimum_jerk(share: Float64) -> Float64:
    u = np.clip(share, 0.0, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


def _bump(t_s: Float64, start_s: float, length_s: float) -> Float64:
    half = 0.4 * length_s
    return _minimum_jerk((t_s - start_s) / half) - _minimum_jerk((t_s - start_s - length_s + half) / half)


def _stations(t_s: Float64, stations: Float64, move_s: float, hold_s: float) -> Float64:
    path = np.repeat(stations[:1], t_s.size, axis=0)
    for number, change in enumerate(np.diff(stations, axis=0)):
        begins_s = 0.8 + number * (move_s + hold_s)
        path = path + _minimum_jerk((t_s - begins_s) / move_s)[:, None] * change
    return path
