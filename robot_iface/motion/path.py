"""The reference path as a quintic spline that is cheap to evaluate once a tick."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, PPoly, make_interp_spline

from robot_iface.types import Float64, ReferencePath

_DEGREE = 5


@dataclass(frozen=True, slots=True)
class Setpoint:
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

    s is the path coordinate: time at full speed, 0 to ``duration_s``. The spline meets every knot and is
        four times
    continuously differentiable; its third and fourth derivatives vanish at both ends, which keeps the ends
    from ringing.

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
        self._starts: list[float] = [float(t_s) for t_s in reference.t_s[:-1]]
        self._joints = len(self.joint_names)
        self._table = _derivative_table(coefficients)

    def evaluate(self, path_s: float, path_speed: float, path_acceleration: float) -> Setpoint:
        """Set-point where the path coordinate is ``path_s`` and moves as given.

        Args:
            path_s: Path coordinate; clamped to the path.
            path_speed: ds/dt.
            path_acceleration: d2s/dt2, per second.

        Returns:
            Positions, velocities and accelerations by the chain rule.
        """
        path_s = min(max(path_s, 0.0), self.duration_s)
        piece = max(bisect_right(self._starts, path_s) - 1, 0)
        u = path_s - self._starts[piece]
        u2 = u * u
        powers = np.array((u2 * u2 * u, u2 * u2, u2 * u, u2, u, 1.0))
        values: Float64 = powers @ self._table[piece]
        joints = self._joints
        slope = values[joints : 2 * joints]
        curvature = values[2 * joints :]
        return Setpoint(
            values[:joints],
            slope * path_speed,
            curvature * (path_speed * path_speed) + slope * path_acceleration,
        )

    def sample(self, path_s: Float64, derivative: int = 0) -> Float64:
        """Derivative of q with respect to s at many coordinates: (n,) -> (n, J), in rad / s^derivative."""
        values: Float64 = self._pieces(path_s, derivative)
        return values

    def start_rad(self) -> Float64:
        """Joint angles where the path begins, (J,)."""
        return self.evaluate(0.0, 0.0, 0.0).q_rad

    def end_rad(self) -> Float64:
        """Joint angles where the path ends, (J,)."""
        return self.evaluate(self.duration_s, 0.0, 0.0).q_rad


def _derivative_table(coefficients: Float64) -> Float64:
    """Coefficients of q, q' and q'' side by side, (pieces, 6, 3 J), so that one product gives all three."""
    order, pieces, joints = coefficients.shape
    table = np.zeros((pieces, order, 3 * joints))
    block = np.moveaxis(coefficients, 1, 0)
    for derivative in range(3):
        table[:, derivative:, derivative * joints : (derivative + 1) * joints] = block
        powers = np.arange(order - 1 - derivative, 0, -1, dtype=np.float64)
        block = block[:, : powers.size] * powers[None, :, None]
    return table
