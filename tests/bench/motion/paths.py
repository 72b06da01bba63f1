"""How exactly the set-point keeps to the path, beside a full-DoF ruckig that chases a moving target."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from ruckig import InputParameter, OutputParameter, Ruckig, RuckigError
from scipy.interpolate import make_interp_spline

from robot_iface.motion import PathPlayer, QuinticPath
from robot_iface.runtime import Pause, Resume, Reverse, SetSpeed
from robot_iface.types import Float64, Plan
from tests.bench.motion.table import Row, at_most, beside
from tests.robot_iface.conftest import Course, fist, make_plan

PERIOD_S = 1e-3
SPEEDS = (0.25, 0.5, 1.0)
ACCELERATION, JERK = 2.0, 20.0
MUST_RAD = 1e-6
_MS = 1e3
_INTERRUPTED = ((900, "pause"), (1500, "resume"), (2300, "reverse"), (3000, "resume"))


@dataclass(frozen=True, slots=True)
class Played:
    """One way along a path.

    Attributes:
        deviation_rad: Largest distance of a set-point from the path, any joint.
        speed: Largest directed speed as a share of today's limit.
        acceleration: Largest path acceleration as a share of its bound.
        jerk: Largest path jerk as a share of its bound.
        integral_rad: Largest error of the speeds' own integral against the positions.
    """

    deviation_rad: float
    speed: float
    acceleration: float
    jerk: float
    integral_rad: float


def played(plan: Plan, speed: float, *, interrupted: bool) -> Played:
    """Play a path to its end, with pause, resume and reverse on the way or without."""
    assert plan.path is not None
    path = QuinticPath(plan.path)
    back = path.fastest_back(plan.limits)
    player = PathPlayer(path.duration_s, PERIOD_S, speed, back_speed=back)
    orders = dict(_INTERRUPTED) if interrupted else {}
    states, points = [player.state], [path.evaluate(0.0, 0.0, 0.0)]
    while not states[-1].at_end:
        order = orders.get(len(states))
        if order is not None:
            getattr(player, order)()
        states.append(player.step())
        points.append(path.evaluate(*states[-1][:3]))
    q = np.array([point.q_rad for point in points])
    dq = np.array([point.dq_rad_s for point in points])
    way = np.array([state[:3] for state in states])
    limits = plan.limits
    allowed = np.where(dq > 0.0, limits.flexion_speed_rad_s, limits.extension_speed_rad_s)
    drawn = q[0] + np.cumsum(0.5 * (dq[1:] + dq[:-1]) * PERIOD_S, axis=0)
    return Played(
        float(np.abs(q - _reference(plan, way[:, 0])).max()),
        float((np.abs(dq) / allowed).max()),
        float(np.abs(np.diff(way[:, 1])).max()) / (ACCELERATION * PERIOD_S),
        float(np.abs(np.diff(way[:, 2])).max()) / (JERK * PERIOD_S),
        float(np.abs(q[1:] - drawn).max()),
    )


def _reference(plan: Plan, path_s: Float64) -> Float64:
    """The path itself at coordinates, (n, J), by another spline routine than the player's kernel."""
    assert plan.path is not None
    free = np.zeros(len(plan.path.joint_names))
    ends = ([(3, free), (4, free)], [(3, free), (4, free)])
    spline: Any = make_interp_spline(plan.path.t_s, plan.path.q_rad, k=5, bc_type=ends)
    reference: Float64 = spline(path_s)
    return reference


@dataclass(frozen=True, slots=True)
class Chase:
    """What becomes of a path that a full-DoF ruckig chases.

    Attributes:
        lag_s: The shift in time at which it fits best.
        deviation_rad: Largest distance from the moving target, any joint.
        failed: Ticks in which the generator raised an error.
        tick_us: Median cost of a tick.
    """

    lag_s: float
    deviation_rad: float
    failed: int
    tick_us: float


def chase(plan: Plan, speed: float, *, with_speed: bool) -> Chase:
    """Give a ruckig of all joints the moving path as its target, with the plan's own speed limits.

    Where it fails, the tick is lost: the set-point stands still.

    Args:
        plan: Path and limits.
        speed: Path speed.
        with_speed: Whether the target carries its speed, or is a place to come to rest at.
    """
    assert plan.path is not None
    path, joints = QuinticPath(plan.path), len(plan.joint_names)
    otg, order, output = Ruckig(joints, PERIOD_S), InputParameter(joints), OutputParameter(joints)
    start = path.start_rad()
    most = np.maximum(plan.limits.flexion_speed_rad_s, plan.limits.extension_speed_rad_s)
    order.current_position, order.current_velocity = start.tolist(), [0.0] * joints
    order.current_acceleration = [0.0] * joints
    order.max_velocity = (most + 1e-3).tolist()
    order.max_acceleration, order.max_jerk = [5.0] * joints, [50.0] * joints
    player = PathPlayer(path.duration_s, PERIOD_S, speed)
    wanted, given, spent, failed = [], [start], [], 0
    while not player.state.at_end:
        at = player.step()
        goal = path.evaluate(at.s, at.s_dot, at.s_ddot)
        order.target_position = goal.q_rad.tolist()
        order.target_velocity = (goal.dq_rad_s if with_speed else 0.0 * goal.dq_rad_s).tolist()
        begun = time.perf_counter_ns()
        try:
            otg.update(order, output)
            output.pass_to_input(order)
            given.append(np.array(output.new_position))
        except (RuckigError, ValueError):
            failed += 1
            order.current_velocity = order.current_acceleration = [0.0] * joints
            given.append(given[-1])
        spent.append(time.perf_counter_ns() - begun)
        wanted.append(goal.q_rad)
    away = np.abs(np.subtract(wanted, given[1:]))
    lag_s = _lag_s(np.array(wanted), np.array(given[1:]))
    return Chase(lag_s, float(away.max()), failed, float(np.median(spent)) / 1e3)


def _lag_s(wanted: Float64, given: Float64) -> float:
    """The shift in time at which the given positions fit the wanted ones best."""
    errors = [
        float(np.sqrt(((given[shift:] - wanted[: len(wanted) - shift]) ** 2).mean())) for shift in range(150)
    ]
    return int(np.argmin(errors)) * PERIOD_S


def measured_deviation_deg(speed: float, *, interrupted: bool = False) -> tuple[float, float]:
    """RMS and largest deviation of a sound hand's measured angles from the reference, degrees."""
    orders = ((2.5, Pause()), (3.2, Resume()), (4.0, Reverse()), (4.6, Resume()), (5.0, SetSpeed(0.3)))
    plan = make_plan("healthy", path=fist(4.0), speed=speed)
    run = Course(plan, orders if interrupted else ())
    moving: Any = run.moving(0)
    error = (run.column("q_rad") - run.column("q_reference_rad"))[moving]
    return float(np.rad2deg(np.sqrt((error**2).mean()))), float(np.rad2deg(np.abs(error).max()))


def path_rows() -> list[Row]:
    """Set-point, share of the limits, measured deviation and the chase."""
    plan = make_plan("healthy", path=fist(4.0))
    rows: list[Row] = []
    for speed in SPEEDS:
        for interrupted in (False, True):
            one = played(plan, speed, interrupted=interrupted)
            way = f"{100 * speed:.0f} %" + (", pause, resume, reverse" if interrupted else "")
            rows.append(at_most(f"set-point off the path, {way}", one.deviation_rad, MUST_RAD, unit=" rad"))
            most = max(one.speed, one.acceleration, one.jerk)
            shares = f"{one.speed:.2f} / {one.acceleration:.2f} / {one.jerk:.2f}"
            rows.append(
                Row(f"v / a / jerk as a share of the limit, {way}", "<= 1", "", shares, most <= 1.0 + 1e-6)
            )
        rms, peak = measured_deviation_deg(speed)
        rows.append(
            beside(f"measured deviation, {100 * speed:.0f} %, healthy", f"{rms:.2f} deg rms, {peak:.2f} peak")
        )
        rows.extend(_chase_row(plan, speed, with_speed=with_speed) for with_speed in (False, True))
    rms, peak = measured_deviation_deg(0.5, interrupted=True)
    rows.append(
        beside("measured deviation through pause, resume, reverse", f"{rms:.2f} deg rms, {peak:.2f} peak")
    )
    return rows


def _chase_row(plan: Plan, speed: float, *, with_speed: bool) -> Row:
    one = chase(plan, speed, with_speed=with_speed)
    what = "place and speed" if with_speed else "place"
    return beside(
        f"peer: ruckig of all joints chasing {what}, {100 * speed:.0f} %",
        f"lag {one.lag_s * _MS:.0f} ms, {np.rad2deg(one.deviation_rad):.2f} deg off at most, "
        f"{one.failed} ticks failed, {one.tick_us:.0f} us",
    )
