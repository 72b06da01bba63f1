"""Where to hold an object so that fingers closed to contact come nearest to it: all minima are searched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.grasp.closing import CONTACT_M, Bool, Closed, FingerClosing
from sessions.records.fields import Float64, Int64

_Z_SAMPLES = 31
_ALPHA_SAMPLES = 5
_MINIMA = 4
_ROUNDS = 9
_COARSE, _FINE = 6, 36
_SHRINK = 0.45


@dataclass(frozen=True, slots=True)
class Held:
    """One place and the fingers closed there.

    Attributes:
        z_m: Height of the little finger's knuckle over the object's axis.
        alpha_rad: Inclination of the object.
        objective_m: Sum of the distances of the joints from the surface; infinite where the grip fails.
        closed: The fingers, of one place (B = 1).
        why: Why the grip fails, by finger; empty where it holds.
    """

    z_m: float
    alpha_rad: float
    objective_m: float
    closed: Closed
    why: tuple[str, ...]


def search(
    closing: FingerClosing,
    z_range_m: tuple[float, float],
    alpha_range_rad: tuple[float, float],
    in_palm: tuple[int, ...],
) -> Held:
    """The best place in a range: a grid, then every one of its lowest valleys by shrinking squares.

    Args:
        closing: Hand and object.
        z_range_m: Heights to search.
        alpha_range_rad: Inclinations to search; one value twice for a fixed one.
        in_palm: Fingers (0 is the index) whose knuckle must not stand below the object's axis: there the
            object lies in the palm.
    """
    valley = _Valley(closing, alpha_range_rad, in_palm)
    z = np.linspace(*z_range_m, _Z_SAMPLES)
    fixed = alpha_range_rad[0] == alpha_range_rad[1]
    alpha = np.linspace(*alpha_range_rad, 1 if fixed else _ALPHA_SAMPLES)
    cost = valley.costs(np.repeat(z, len(alpha)), np.tile(alpha, len(z))).reshape(len(z), len(alpha))
    rows, columns = _valleys(cost)
    best = z[rows], alpha[columns], cost[rows, columns]
    step_z = (z[1] - z[0]) / 2
    step_alpha = 0.0 if fixed else (alpha[1] - alpha[0]) / 2
    for _ in range(_ROUNDS):
        best = valley.around(best, (step_z, step_alpha))
        step_z, step_alpha = step_z * _SHRINK, step_alpha * _SHRINK
    least = int(np.argmin(best[2]))
    return hold(closing, float(best[0][least]), float(best[1][least]))


def hold(closing: FingerClosing, z_m: float, alpha_rad: float) -> Held:
    """The fingers closed finely in one place."""
    closed = closing.close(np.array([z_m]), np.array([alpha_rad]), _FINE)
    cost = float(_objective(closing, closed)[0])
    return Held(z_m, alpha_rad, cost, closed, _reasons(closed))


def _objective(closing: FingerClosing, closed: Closed) -> Float64:
    total = closing.joint_distance_m(closed.points_m).sum(axis=(-1, -2))
    return np.where(_holds(closed).all(axis=(-1, -2)), total, np.inf)


def _holds(closed: Closed) -> Bool:
    """Knuckle met, finger met, nothing inside the object: shape (B, 4, 3)."""
    clear = closed.gap_m.min(axis=-1) >= -CONTACT_M
    return np.concatenate([closed.met, clear[..., None]], axis=-1)


def _reasons(closed: Closed) -> tuple[str, ...]:
    words = (
        "the knuckle's range ends before a link touches",
        "the middle joint's range ends before a link touches",
        "a straight finger already cuts the object",
    )
    broken = ~_holds(closed)[0].all(axis=0)
    return tuple(word for word, fails in zip(words, broken, strict=True) if fails)


def _valleys(cost: Float64) -> tuple[Int64, Int64]:
    """Rows and columns of the lowest local minima of a grid (its lowest cell where all are infinite)."""
    wide = np.pad(cost, 1, constant_values=np.inf)
    least = np.ones(cost.shape, dtype=np.bool_)
    for row in range(3):
        for column in range(3):
            least &= cost <= wide[row : row + cost.shape[0], column : column + cost.shape[1]]
    rows, columns = np.nonzero(least)
    order = np.argsort(cost[rows, columns], kind="stable")[:_MINIMA]
    return rows[order], columns[order]


class _Valley:
    """The objective over places, infinite where the grip fails."""

    def __init__(
        self, closing: FingerClosing, alpha_range_rad: tuple[float, float], in_palm: tuple[int, ...]
    ) -> None:
        self._closing = closing
        self._alpha_range_rad = alpha_range_rad
        self._in_palm = list(in_palm)

    def costs(self, z_m: Float64, alpha_rad: Float64) -> Float64:
        """Objective of places, shape (B,), m."""
        cost = np.full(len(z_m), np.inf)
        volar = (self._closing.heights_m(z_m, alpha_rad)[:, self._in_palm] >= 0.0).all(axis=1)
        if bool(volar.any()):
            closed = self._closing.close(z_m[volar], alpha_rad[volar], _COARSE)
            cost[volar] = _objective(self._closing, closed)
        return cost

    def around(
        self, best: tuple[Float64, Float64, Float64], steps: tuple[float, float]
    ) -> tuple[Float64, Float64, Float64]:
        """The best of each valley's place and the square of neighbours around it."""
        one = np.array([-1.0, 0.0, 1.0])
        dz, da = (grid.ravel() for grid in np.meshgrid(one, one if steps[1] else np.zeros(1), indexing="ij"))
        z = best[0][:, None] + steps[0] * dz
        alpha = np.clip(best[1][:, None] + steps[1] * da, *self._alpha_range_rad)
        cost = self.costs(z.ravel(), alpha.ravel()).reshape(z.shape)
        row, least = np.arange(len(z)), np.argmin(cost, axis=1)
        better = cost[row, least] < best[2]
        return (
            np.where(better, z[row, least], best[0]),
            np.where(better, alpha[row, least], best[1]),
            np.where(better, cost[row, least], best[2]),
        )
