"""The duties of one control tick written down in plain numpy, as lean as the author could: the peer of ours.

Flat arrays, no objects, stacked comparisons, one record row. Left out are what costs the product something
and the peer nothing: orders, phases, events, the stop's latching, messages and their digest.
"""

from __future__ import annotations

import numpy as np

from robot_iface.control import thesis_gains
from robot_iface.motion import PathPlayer, QuinticPath
from robot_iface.types import Float64, Plan

_FEED_STEP_S = 0.01
_RECORD_ROWS = 12
_BLOCK = 50
_POWERS = np.arange(5, -1, -1)
_FIRST = _POWERS.astype(float)
_SECOND = _FIRST * (_FIRST - 1.0)


def _clip(values: Float64, low: Float64 | float, high: Float64 | float) -> Float64:
    """As ``np.clip``, in half its time."""
    return np.minimum(np.maximum(values, low), high)


class NumpyTick:
    """Path with two derivatives, easing, learnt torque, law, adaptation, checks, watchdogs and record.

    Args:
        plan: A plan with a path.
        period_s: Control period.
        assistive: Whether help is adapted as well.
    """

    def __init__(self, plan: Plan, period_s: float, *, assistive: bool) -> None:
        assert plan.path is not None
        path, limits, joints = QuinticPath(plan.path), plan.limits, len(plan.joint_names)
        gains = thesis_gains(plan.joint_names)
        self._period_s, self._assistive = period_s, assistive
        self._knots: Float64 = np.array(plan.path.t_s)
        starts = self._knots[:-1]
        factorial = np.array([120.0, 24.0, 6.0, 2.0, 1.0, 1.0])
        self._pieces: Float64 = np.stack(
            [
                path.sample(starts, int(power)) / scale
                for power, scale in zip(_POWERS, factorial, strict=True)
            ],
            axis=1,
        )
        self._player = PathPlayer(path.duration_s, period_s, plan.prescription.speed)
        bins = int(np.ceil(path.duration_s / _FEED_STEP_S)) + 2
        self._learnt, self._errors = np.zeros((bins, joints)), np.zeros((bins, joints))
        self._counts = np.zeros(bins)
        self._low, self._high = limits.q_min_rad, limits.q_max_rad
        self._stiffness, self._damping = gains.stiffness_nm_rad, gains.damping_nms_rad
        self._limit_nm = limits.tau_interaction_nm
        self._cap_nm: Float64 = np.minimum(limits.tau_nm, 0.95 * self._limit_nm)
        self._spring_nm = 0.9 * self._limit_nm
        self._wanted_multiple = np.full(joints, plan.prescription.stiffness_multiple)
        self._multiple: Float64 = np.ones(joints)
        self._tau_ff: Float64 = np.zeros(joints)
        self._felt: Float64 = np.zeros(joints)
        self._fed: Float64 = np.zeros(joints)
        self._seen = np.zeros((3, joints))
        self._lead: Float64 = np.zeros(joints)
        self._last: Float64 = np.zeros((5, joints))
        self._last_q: Float64 = np.array(plan.path.q_rad[0])
        self._slow: Float64 = np.zeros(joints)
        self._energy: Float64 = np.zeros(joints)
        ones = np.ones(joints)
        self._bounds: Float64 = np.stack(
            (
                ones * np.deg2rad(5.0),
                0.5 * (self._high - self._low) + limits.margin_rad,
                ones * limits.trip_speed_rad_s,
                3.0 * limits.tau_nm,
                3.0 * limits.tau_nm,
                ones * limits.tau_rate_nm_s * period_s,
                ones * limits.power_w,
                self._limit_nm,
                ones * 3e-4,
            )
        )
        self._basis, self._met = np.zeros((3, 6)), np.zeros((9, joints))
        self._middle: Float64 = 0.5 * (self._low + self._high)
        self._records: Float64 = np.empty((_BLOCK, _RECORD_ROWS * joints))
        self._scalars: Float64 = np.empty((_BLOCK, 4))
        self._count = 0
        self._overload_s = self._held_s = 0.0
        self._last_ns = 0

    def step(
        self, t_ns: int, q: Float64, second: Float64, dq: Float64, tau: Float64, load: Float64
    ) -> tuple[Float64, Float64]:
        """One tick: reading in, position and speed of the command out, (J,) each."""
        at = self._player.step()
        wanted, speed = self._point(at.s, at.s_dot, at.s_ddot)
        error = wanted - q
        forward = self._feed_forward(at.s, q, error)
        if self._assistive:
            wanted = self._adapt(wanted, speed, error, dq, load)
            error = wanted - q
        command = self._law(q, speed, error, forward, load)
        requested, applied, fine = self._check(q, second, dq, tau, load, command)
        assert fine
        assert self._watch(t_ns, load, speed, dq)
        count = self._count % _BLOCK
        self._count += 1
        self._scalars[count] = t_ns, at.s, at.s_dot, 3.0
        rows = (q, dq, tau, load, wanted, *command, requested, applied)
        np.concatenate(rows, out=self._records[count])
        return command[0], command[1]

    def _point(self, s: float, s_dot: float, s_ddot: float) -> tuple[Float64, Float64]:
        piece = min(int(np.searchsorted(self._knots, s, side="right")) - 1, len(self._pieces) - 1)
        u = s - self._knots[piece]
        row = self._pieces[piece]
        powers, basis = u**_FIRST, self._basis
        basis[0] = powers
        basis[1, :5] = s_dot * _FIRST[:5] * powers[1:]
        basis[2, :5] = s_ddot * _FIRST[:5] * powers[1:]
        basis[2, :4] += s_dot * s_dot * _SECOND[:4] * powers[2:]
        here: Float64 = basis @ row
        return here[0], here[1]

    def _feed_forward(self, s: float, q: Float64, error: Float64) -> Float64:
        place = s / _FEED_STEP_S
        low = min(int(place), len(self._learnt) - 2)
        part = min(place - low, 1.0)
        tau = self._learnt[low] * (1.0 - part) + self._learnt[low + 1] * part
        room = np.where(tau > 0.0, self._high - q, q - self._low)
        tau = tau * _clip(room / 0.05, 0.0, 1.0)
        nearest = min(int(place + 0.5), len(self._counts) - 1)
        self._errors[nearest] += error
        self._counts[nearest] += 1.0
        per_multiple = self._stiffness * np.abs(error)
        free = self._multiple * per_multiple <= self._spring_nm
        most = np.where(free, np.minimum(1.5e-4 / (per_multiple + 1e-9), 3e-3), 3e-3)
        self._multiple = self._multiple + _clip(self._wanted_multiple - self._multiple, -most, most)
        self._tau_ff = self._tau_ff + _clip(tau - self._tau_ff, -5e-4, 5e-4)
        return self._tau_ff

    def _adapt(self, wanted: Float64, speed: Float64, error: Float64, dq: Float64, load: Float64) -> Float64:
        way = np.sign(speed)
        length = float(np.sqrt(speed @ speed)) + 1e-9
        along = float(speed @ error) / length
        share = -max(along, -0.26) / length if along < 0.0 else 0.0
        self._lead = self._lead + _clip(speed * share - self._lead, -5e-4, 5e-4)
        if self._count % 10 == 1:
            self._seen[0] += np.maximum(error * way, 0.0)
            self._seen[1] += load * way
            self._seen[2] += (np.abs(speed) > 0.09) & (dq * way < 0.09)
        return wanted + self._lead

    def _law(self, q: Float64, speed: Float64, error: Float64, forward: Float64, load: Float64) -> Float64:
        stiffness = self._stiffness * self._multiple
        damping = self._damping * np.sqrt(self._multiple)
        most = self._spring_nm / (stiffness + 1e-9)
        self._felt = 0.73 * self._felt + 0.27 * load
        self._fed = self._fed + _clip(-0.0 * self._felt - self._fed, -0.02, 0.02)
        return np.stack((q + _clip(error, -most, most), speed, forward + self._fed, stiffness, damping))

    def _check(
        self, q: Float64, second: Float64, dq: Float64, tau: Float64, load: Float64, command: Float64
    ) -> tuple[Float64, Float64, bool]:
        last, half = self._last, 0.5 * (self._last_q + q)
        ideal = last[3] * (last[0] - half) + last[4] * (last[1] - dq) + last[2]
        excess = tau - ideal
        self._slow = self._slow + 0.02 * (excess - self._slow)
        slip = last[1] - dq
        gained = (excess - self._slow) * (q - self._last_q) - last[4] * slip * slip * self._period_s
        self._energy = np.maximum(0.995 * self._energy + gained, 0.0)
        before = last[3] * (last[0] - q) + last[4] * (last[1] - dq) + last[2]
        inner = _clip(command[0], self._low, self._high)
        requested = command[3] * (command[0] - q) + command[4] * (command[1] - dq) + command[2]
        pulled = requested + command[3] * (inner - command[0])
        applied = _clip(pulled, -self._cap_nm, self._cap_nm)
        met = self._met
        np.subtract(q, second, out=met[0])
        np.subtract(q, self._middle, out=met[1])
        met[2], met[3], met[4] = dq, tau, requested
        np.subtract(requested, before, out=met[5])
        np.multiply(applied, dq, out=met[6])
        met[7], met[8] = load, self._energy
        shares = np.abs(met) / self._bounds
        fine = bool(np.isfinite(shares.sum())) and float(shares.max()) <= 1.0
        self._last, self._last_q = command, q
        return requested, applied, fine

    def _watch(self, t_ns: int, load: Float64, speed: Float64, dq: Float64) -> bool:
        gap_ns, self._last_ns = t_ns - self._last_ns, t_ns
        share = float((np.abs(load) / self._limit_nm).max())
        self._overload_s = self._overload_s + self._period_s if share > 1.0 else 0.0
        held = share > 0.5 and float(np.abs(speed).max()) < 0.01 and float(np.abs(dq).max()) < 0.09
        self._held_s = self._held_s + self._period_s if held else 0.0
        return 0 <= gap_ns <= 10**8 and self._overload_s < 0.01 and self._held_s < 3.0
