"""Kinematics, fit and trigger, each beside its oracle or peer."""

from __future__ import annotations

import numpy as np

from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, finger_inverse, finger_points
from robot_iface.types import Float64, VirtualKind
from tests.bench.motion.fit import NOISES_M, fit_table
from tests.bench.motion.table import Row, at_most, beside
from tests.bench.motion.trigger_map import KINDS, false_starts
from tests.robot_iface.conftest import Course, fist, make_plan

SAMPLES = 2000
TRIALS = 1000
SEED = 7300
STARTERS: tuple[VirtualKind, ...] = ("healthy", "weak")
CUED_PATHS = ((2.0, 25.0), (2.0, 8.0), (3.0, 8.0))
"""Duration in s and first angle in degrees: near the resting hand, away from it, and a slow beginning."""
_TABLE = ((0.0, 0.0, 0.0, 0.0), (-90.0, 0.0, 0.0, 0.0), (0.0, 55e-3, 0.0, 0.0), (0.0, 25e-3, -90.0, 0.0))
_TIP = (-90.0, 0.0, 180.0, 25e-3)
"""Table 5.3 as it is printed: alpha deg, a m, offset of theta deg, d m."""


def modified_dh_m(finger_rad: Float64) -> Float64:
    """MCP, PIP, DIP joint and tip by elementary rotations and shifts in Craig's order, (4, 3)."""
    at, points = np.eye(4), []
    moves = (finger_rad[0], finger_rad[1], finger_rad[2], finger_rad[2], 0.0)
    for (alpha, a, offset, d), move in zip((*_TABLE, _TIP), moves, strict=True):
        at = at @ _turn(np.deg2rad(alpha), 0) @ _shift(a, 0)
        at = at @ _turn(float(move) + np.deg2rad(offset), 2) @ _shift(d, 2)
        points.append(at[:3, 3])
    return np.array(points[1:])


def _turn(angle_rad: float, axis: int) -> Float64:
    turn, (one, two) = np.eye(4), [(1, 2), (2, 0), (0, 1)][axis]
    turn[one, one] = turn[two, two] = np.cos(angle_rad)
    turn[one, two], turn[two, one] = -np.sin(angle_rad), np.sin(angle_rad)
    return turn


def _shift(length_m: float, axis: int) -> Float64:
    shift = np.eye(4)
    shift[axis, 3] = length_m
    return shift


def kinematics_rows() -> list[Row]:
    """Largest differences over random postures of a finger."""
    q = np.random.default_rng(SEED).uniform(FINGER_MIN_RAD, FINGER_MAX_RAD, (SAMPLES, 3))
    points = finger_points(q)
    expected = np.array([modified_dh_m(one) for one in q])
    found = finger_inverse(points[:, 3])
    bent = q[:, 2] > np.deg2rad(5.0)
    back_rad = float(np.abs(found - q)[bent].max())
    return [
        at_most("kinematics against modified DH", float(np.abs(points - expected).max()), 1e-9, unit=" m"),
        at_most("IK round trip, joints (PIP over 5 deg)", back_rad, 1e-6, unit=" rad"),
        at_most(
            "IK round trip, fingertip",
            float(np.abs(finger_points(found)[:, 3] - points[:, 3]).max()),
            1e-9,
            unit=" m",
        ),
    ]


def fit_rows(seeds: tuple[int, ...] = (201, 202, 203)) -> list[Row]:
    """Error of the joint fit over that of filter-then-IK at its best cutoff."""
    table, rows = fit_table(seeds), []
    for seen in ("fingertips", "landmarks"):
        for noise_m in NOISES_M:
            mine = [row for row in table if row.seen == seen and row.noise_m == noise_m]
            fit = float(np.sqrt(np.mean([row.fit_rad**2 for row in mine])))
            peer = float(np.sqrt(np.mean([row.peer_rad**2 for row in mine])))
            what = f"joint fit / Hampel + Butterworth + IK at its best, {seen}, {1e3 * noise_m:.0f} mm"
            rows.append(at_most(what, fit / peer, 0.7, 0.5))
            degrees = f"{np.rad2deg(fit):.2f} beside {np.rad2deg(peer):.2f} deg"
            rows.append(beside(f"the same, rms over {len(mine)} movements", degrees))
    return rows


def trigger_rows() -> list[Row]:
    """False starts in a thousand trials by condition."""
    rows: list[Row] = []
    for number, kind in enumerate(KINDS):
        count = false_starts(kind, TRIALS, SEED + number)
        rows.append(Row(f"false starts in {TRIALS}: {kind}", "0", "", str(count), count == 0))
    return rows + [_latency_row(kind, *path) for path in CUED_PATHS for kind in STARTERS]


def _latency_row(kind: VirtualKind, duration_s: float, start_deg: float) -> Row:
    """From the cue to the first tick of the movement, path speed 0.5, simulated exoskeleton."""
    run = Course(make_plan(kind, "assistive", path=fist(duration_s, 22.0, start_deg)))
    since = {phase.phase: phase.t_ns for phase in reversed(run.phases)}
    started = ", ".join(sorted(run.started_by(0)))
    latency_s = (since["move"] - since["cue"]) * 1e-9
    where = f"path of {duration_s:g} s from {start_deg:g} deg"
    return at_most(
        f"latency of the trigger, {kind}, {where}, started by the {started}", latency_s, 1.2, 0.8, " s"
    )
