"""The reference path as a quintic spline that is cheap to evaluate once a tick."""

from __future__ import annotations

import math
from copy import copy
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, PPoly, make_interp_spline

from robot_iface.motion.kernels import point_on_path
from robot_iface.motion.narrowing import Narrowing, unchanged
from robot_iface.types import Float64, Limits, ReferencePath

_DEGREE = 5
_GRID_S = 0.002
_BETWEEN_SAMPLES = 0.999
"""What is taken off a speed because the path was only looked at every 2 ms."""


class Setpoint(NamedTuple):
    """Where the joints should be at one instant. Arrays are (J,).

    Attributes:
        q_rad: Desired positions.
        dq_rad_s: Desired velocities.
        ddq_rad_s2: Desired accelerations.
    """

    q_rad: Float64
    dq_rad_s: Float64
    ddq_rad_s2: Float64


class QuinticPath:
    """Quintic interpolating spline q(s) through the knots of a reference, all joints together.

    s is the path coordinate: time at full speed, 0 to ``duration_s``. The spline meets every knot and is four
    times continuously differentiable; its third and fourth derivatives vanish at both ends, which keeps the
    ends from ringing.

    Args:
        reference: The approved take, made playable.
    """

    def __init__(self, reference: ReferencePath) -> None:
        free: Float64 = np.zeros(len(reference.joint_names))
        ends = ([(3, free), (4, free)], [(3, free), (4, free)])
        spline: BSpline = make_interp_spline(reference.t_s, reference.q_rad, k=_DEGREE, bc_type=ends, axis=0)
        self.joint_names: tuple[str, ...] = reference.joint_names
        self.duration_s: float = float(reference.t_s[-1])
        # Taylor coefficients at the left knot of each piece, highest power first, as PPoly wants them.
        coefficients: Float64 = np.stack(
            [spline(reference.t_s[:-1], nu=power) / math.factorial(power) for power in range(_DEGREE, -1, -1)]
        )
        self._pieces = PPoly(coefficients, reference.t_s)
        self._coefficients: Float64 = np.ascontiguousarray(np.moveaxis(coefficients, 1, 0))
        self._starts: Float64 = np.array(reference.t_s[:-1])
        self._narrowing = unchanged(len(self.joint_names))
        self._span: tuple[Float64, Float64] | None = None
        self.evaluate(0.0, 0.0, 0.0)  # compiles what a tick will call

    def within(self, narrowing: Narrowing) -> QuinticPath:
        """The same path with less range (of the original, not of an already narrowed one)."""
        other = copy(self)
        other._narrowing = narrowing
        return other

    def evaluate(self, path_s: float, path_speed: float, path_acceleration: float) -> Setpoint:
        """Set-point where the path coordinate is ``path_s`` and moves as given.

        Args:
            path_s: Path coordinate; clamped to the path.
            path_speed: ds/dt.
            path_acceleration: d2s/dt2, per second.

        Returns:
            Positions, velocities and accelerations by the chain rule.
        """
        out = np.empty((3, len(self.joint_names)))
        here = min(max(path_s, 0.0), self.duration_s)
        point_on_path(
            *(self._coefficients, self._starts, self._narrowing.table),
            *(here, path_speed, path_acceleration, out),
        )
        return Setpoint(out[0], out[1], out[2])

    def sample(self, path_s: Float64, derivative: int = 0) -> Float64:
        """Derivative of q with respect to s at many coordinates: (n,) -> (n, J), in rad / s^derivative."""
        values: Float64 = self._pieces(path_s, derivative)
        if derivative == 0:
            return self._narrowing.apply(values)
        return self._narrowing.scale * values

    def span_rad(self) -> tuple[Float64, Float64]:
        """Least and greatest angle of each joint along the whole original path, (J,) each."""
        if self._span is None:
            values: Float64 = self._pieces(self._grid())
            self._span = values.min(axis=0), values.max(axis=0)
        return self._span

    def fastest_back(self, limits: Limits) -> float:
        """Highest path speed at which the whole path may be played backwards.

        Backwards, a joint that flexed extends: the limit of the other direction applies.

        Args:
            limits: Directed speed limits of the joints.
        """
        slope = self.sample(self._grid(), 1)
        allowed = np.where(slope > 0.0, limits.extension_speed_rad_s, limits.flexion_speed_rad_s)
        need = float((np.abs(slope) / allowed).max())
        return _BETWEEN_SAMPLES / need if need > 0.0 else math.inf

    def start_rad(self) -> Float64:
        """Joint angles where the path begins, (J,)."""
        return self.evaluate(0.0, 0.0, 0.0).q_rad

    def end_rad(self) -> Float64:
        """Joint angles where the path ends, (J,)."""
        return self.evaluate(self.duration_s, 0.0, 0.0).q_rad

    def _grid(self) -> Float64:
        """Coordinates close enough together that nothing of a smooth path is missed between them."""
        return np.linspace(0.0, self.duration_s, math.ceil(self.duration_s / _GRID_S) + 1)
