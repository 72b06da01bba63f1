"""The optimum of the thesis's objective (eq. 5.1) by a safeguarded Newton method; one posture, or many.

The sum of the surface distances is a sum of one function of each knuckle's height, and the heights are linear
in z and tan(alpha): gradient and 2 x 2 Hessian are closed-form. Where the Hessian is not positive definite it
is shifted until it is, and a step that does not lower the sum is halved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.tangent import distance_terms, offsets_m
from sessions.records.fields import Float64

_ITERATIONS = 60
_STILL_M = 1e-13
_LARGEST_STEP = (0.05, 0.7)  # of z in metres and of tan(alpha)
_SHIFT = 1e-6
_CHUNK = 250
_LAST_STEP = (1e-6, 1e-5)  # of z and tan(alpha): squared by the next one, which is left out


@dataclass(frozen=True, slots=True)
class Optimum:
    """Where the hand should be.

    Attributes:
        z_m: Height of the little finger's knuckle over the object's axis.
        alpha_rad: Inclination of the object's axis against the row of knuckles.
        objective_m: Sum of the distances of the joints from the surface.
        iterations: Newton steps taken.
    """

    z_m: float
    alpha_rad: float
    objective_m: float
    iterations: int


class TangentObjective:
    """Eq. 5.1 of one hand around cylinders.

    Args:
        hand: The hand.
    """

    def __init__(self, hand: GraspHand) -> None:
        distal, lateral = offsets_m(hand)
        self._fingers = [
            (
                float(distal[i]),
                float(lateral[i]),
                float(hand.links_m[i, 0]),
                float(hand.links_m[i, 1]),
                (hand.palm_half_m, float(hand.half_m[i, 0]), float(hand.half_m[i, 1])),
            )
            for i in range(4)
        ]
        self._distal, self._lateral = distal[:, None], lateral[:, None]
        self._links = hand.links_m[:, 0, None], hand.links_m[:, 1, None]
        self._half = hand.palm_half_m, hand.half_m[:, 0, None], hand.half_m[:, 1, None]
        # heights as near nought as four knuckles allow: a start that is close to the optimum
        mean_d, mean_l = float(distal.mean()), float(lateral.mean())
        spread = ((lateral - mean_l) * (distal - mean_d)).sum() / ((lateral - mean_l) ** 2).sum()
        self.start = -mean_d + float(spread) * mean_l, -float(spread)

    def value(self, z_m: float, tan_alpha: float, radius_m: float) -> float:
        """The objective, m."""
        total = 0.0
        for distal, lateral, a1, a2, half in self._fingers:
            total += distance_terms(z_m + distal + lateral * tan_alpha, radius_m, a1, a2, half)[0]
        return total

    def minimum(
        self, radius_m: float, alpha_rad: float | None = None, start: tuple[float, float] | None = None
    ) -> Optimum:
        """The optimum around one cylinder.

        Args:
            radius_m: Radius of the cylinder.
            alpha_rad: Inclination, free unless given.
            start: z in metres and alpha in radians to start from; near the optimum unless given.

        Raises:
            Refused: The radius is too small for tangent links, or no optimum is found.
        """
        z, v = self.start if start is None else (start[0], math.tan(start[1]))
        if alpha_rad is not None:
            z, v = z + (self.start[0] - z if start is None else 0.0), math.tan(alpha_rad)
        free = alpha_rad is None
        try:
            sums = self._sums(z, v, radius_m)
            for step in range(_ITERATIONS):
                dz, dv = _direction(sums, free)
                z, v, after, moved = self._lowered((z, v), (dz, dv), sums, radius_m)
                sums = after
                if moved < _STILL_M:
                    return Optimum(z, math.atan(v), sums[0], step + 1)
        except ValueError as error:
            raise Refused(
                "cylinder radius",
                f"{radius_m:g} m",
                "large enough for a link to lie on it",
                "use method contact",
            ) from error
        raise Refused("optimum", f"not found from z = {z:g} m", "found in 60 steps", "choose another start")

    def minima(self, radius_m: Float64, alpha_rad: Float64 | None = None) -> tuple[Float64, Float64, Float64]:
        """Optima around many cylinders at once.

        Args:
            radius_m: Radii, shape (N,).
            alpha_rad: Inclinations, shape (N,); free unless given.

        Returns:
            z in metres, alpha in radians and the objective in metres, each of shape (N,).
        """
        radius = np.asarray(radius_m, dtype=np.float64)
        parts = [
            self._some(
                radius[row : row + _CHUNK], None if alpha_rad is None else alpha_rad[row : row + _CHUNK]
            )
            for row in range(0, len(radius), _CHUNK)
        ]
        z, alpha, value = (np.concatenate(column) for column in zip(*parts, strict=True))
        return z, alpha, value

    def _some(self, radius: Float64, alpha_rad: Float64 | None) -> tuple[Float64, Float64, Float64]:
        """The optima of some cylinders: few enough for all arrays to stay in the processor's first cache."""
        z = np.full(len(radius), self.start[0])
        v = np.full(len(radius), self.start[1]) if alpha_rad is None else np.tan(alpha_rad)
        value, settled = np.empty(len(radius)), np.zeros(len(radius), dtype=np.bool_)
        for _ in range(12):
            value, gz, gv, hzz, hzv, hvv = self._array_sums(z, v, radius)
            if alpha_rad is None:
                determinant = hzz * hvv - hzv * hzv
                dz, dv = (hzv * gv - hvv * gz) / determinant, (hzv * gz - hzz * gv) / determinant
                settled = (np.abs(dz) < _LAST_STEP[0]) & (np.abs(dv) < _LAST_STEP[1]) & (determinant > 0)
                v = v + np.clip(dv, -_LARGEST_STEP[1], _LARGEST_STEP[1])
            else:
                dz = -gz / hzz
                settled = np.abs(dz) < _LAST_STEP[0]
            z = z + np.clip(dz, -_LARGEST_STEP[0], _LARGEST_STEP[0])
            settled &= hzz > 0
            if bool(settled.all()):
                break
        alpha = np.arctan(v) if alpha_rad is None else np.asarray(alpha_rad, dtype=np.float64)
        for row in np.flatnonzero(~settled):
            one = self.minimum(float(radius[row]), None if alpha_rad is None else float(alpha[row]))
            z[row], alpha[row], value[row] = one.z_m, one.alpha_rad, one.objective_m
        return z, alpha, value

    def _sums(self, z: float, v: float, radius: float) -> tuple[float, float, float, float, float, float]:
        """Objective, its gradient by z and tan(alpha), and the three elements of its Hessian."""
        f = gz = gv = hzz = hzv = hvv = 0.0
        for distal, lateral, a1, a2, half in self._fingers:
            value, slope, bend = distance_terms(z + distal + lateral * v, radius, a1, a2, half)
            f += value
            gz += slope
            gv += slope * lateral
            hzz += bend
            bent = bend * lateral
            hzv += bent
            hvv += bent * lateral
        return f, gz, gv, hzz, hzv, hvv

    def _array_sums(self, z: Float64, v: Float64, radius: Float64) -> tuple[Float64, ...]:
        u = z + self._distal + self._lateral * v
        value, slope, bend = distance_terms(u, radius, *self._links, self._half, np.sqrt)
        lateral = self._lateral[:, 0]
        bent = bend * self._lateral
        return (
            value.sum(axis=0),
            slope.sum(axis=0),
            lateral @ slope,
            bend.sum(axis=0),
            bent.sum(axis=0),
            lateral @ bent,
        )

    def _lowered(
        self,
        at: tuple[float, float],
        step: tuple[float, float],
        sums: tuple[float, float, float, float, float, float],
        radius: float,
    ) -> tuple[float, float, tuple[float, float, float, float, float, float], float]:
        """The step, halved until the objective falls: new place, sums there, and how far it went, m."""
        share = min(
            1.0, _LARGEST_STEP[0] / max(abs(step[0]), 1e-300), _LARGEST_STEP[1] / max(abs(step[1]), 1e-300)
        )
        for _ in range(40):
            z, v = at[0] + share * step[0], at[1] + share * step[1]
            after = self._sums(z, v, radius)
            # at the optimum the sum no longer changes in double precision, but the step is still right
            if after[0] <= sums[0] + 1e-15:
                return z, v, after, share * (abs(step[0]) + 0.05 * abs(step[1]))
            share /= 2
        return at[0], at[1], sums, 0.0


def _direction(sums: tuple[float, float, float, float, float, float], free: bool) -> tuple[float, float]:
    """Newton's step of z and tan(alpha), downhill also where the objective is not convex."""
    _, gz, gv, hzz, hzv, hvv = sums
    if not free:
        return -gz / max(abs(hzz), _SHIFT), 0.0
    determinant = hzz * hvv - hzv * hzv
    if hzz <= 0 or determinant <= 0:
        lowest = (hzz + hvv) / 2 - math.hypot((hzz - hvv) / 2, hzv)
        shift = 1.5 * abs(lowest) + _SHIFT
        hzz, hvv = hzz + shift, hvv + shift
        determinant = hzz * hvv - hzv * hzv
    return (hzv * gv - hvv * gz) / determinant, (hzv * gz - hzz * gv) / determinant
