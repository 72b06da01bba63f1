"""Angles of one digit on a uniform grid, pulled by samples and kept smooth: a banded least-squares problem.

Every sample i says something of the n angles q(t_i) of its digit, as information A_i and vector b_i:
q^T A_i q - 2 b_i^T q. Between two grid points q is a straight line. To their sum comes, joint by joint,
sum (q''' / jerk)^2 at the samples' rate. The unknowns, grid point by grid point, make a band of 3 n + 1 rows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

from sessions.errors import Refused
from sessions.records.fields import Float64, Int64

_THIRD = np.array([-1.0, 3.0, -3.0, 1.0])
_REST_RAD_S = 0.003  # speed that counts as rest at the ends
_NUDGE = 0.05
_GAIN = 0.5  # a change of the evidence that is worth another smoothness

_STILL_RAD_S = 0.05  # of a digit that stands still, as far as noise lets it be seen
_FASTER = 1.5  # by how much a joint may be faster than its digit
_PACE_S = 0.3  # over which speeds are alike
_LOOSE = 1e-3  # precision of where a joint is before anything is seen, rad^-2

LIVELIEST = 3.0
"""How many times its usual jerk a joint may have where its digit moves fast."""
JERKS_RAD_S3 = (2.0, 1000.0)
"""Range in which a joint's usual jerk is looked for."""


@dataclass(frozen=True, slots=True)
class GridSamples:
    """Where N samples lie on a grid of K points.

    Attributes:
        left: Grid point at or before each sample, shape (N,).
        share: How far each lies towards the next one, 0 to 1, shape (N,).
        roughness: Third differences (and rest at the ends) of a joint of jerk 1 rad/s^3 as an upper band,
            diagonal first, shape (4, K).
        pace: First differences of a joint, weighted by how fast it may be, likewise, shape (4, K).
        t_s: The grid, shape (K,).
        per_sample: Samples a grid point.
        at_rest: Whether the ends are held still.
    """

    left: Int64
    share: Float64
    roughness: Float64
    pace: Float64
    t_s: Float64
    per_sample: float
    at_rest: bool

    @property
    def size(self) -> int:
        """K."""
        return self.t_s.size

    @property
    def per_second(self) -> float:
        """Samples a second."""
        return self.per_sample / float(self.t_s[1] - self.t_s[0])

    def read(self, path: Float64) -> Float64:
        """A path (K, n) at the samples, shape (N, n)."""
        share = self.share[:, None]
        read: Float64 = (1.0 - share) * path[self.left] + share * path[self.left + 1]
        return read


def on_grid(t_s: Float64, grid_s: Float64, *, at_rest: bool) -> GridSamples:
    """Lay samples on a grid.

    Args:
        t_s: Sample times, rising, shape (N,).
        grid_s: Uniform grid that covers them, shape (K,).
        at_rest: Whether the hand stands still at both ends of the grid.

    Raises:
        Refused: The grid has fewer than 8 points or does not cover the samples.
    """
    if grid_s.size < 8 or grid_s[0] > t_s[0] + 1e-9 or grid_s[-1] < t_s[-1] - 1e-9:
        value = f"{grid_s.size} points from {grid_s[0]:g} to {grid_s[-1]:g} s"
        raise Refused("grid", value, f"8 or more from {t_s[0]:g} to {t_s[-1]:g} s", "widen the grid")
    left: Int64 = np.clip(np.searchsorted(grid_s, t_s, side="right") - 1, 0, grid_s.size - 2)
    share = np.clip((t_s - grid_s[left]) / (grid_s[left + 1] - grid_s[left]), 0.0, 1.0)
    step_s = float(grid_s[1] - grid_s[0])
    per_sample = step_s * max(t_s.size - 1, 1) / float(t_s[-1] - t_s[0])
    per_sample = step_s * max(t_s.size - 1, 1) / float(t_s[-1] - t_s[0])
    nothing = np.zeros((4, grid_s.size))
    plain = GridSamples(left, share, nothing, nothing, grid_s, per_sample, at_rest)
    return paced(plain, np.full(grid_s.size, 100.0))


def paced(samples: GridSamples, speed_rad_s: Float64) -> GridSamples:
    """The same grid, smooth and slow where little moves, less so where much does.

    Args:
        samples: The grid.
        speed_rad_s: How fast the digit moves at each grid point, shape (K,).
    """
    step_s = float(samples.t_s[1] - samples.t_s[0])
    lively = (speed_rad_s + _STILL_RAD_S) ** 2
    usual = float(np.exp(np.log(lively).mean()))
    third = np.maximum(usual / np.convolve(lively, np.full(4, 0.25), "valid"), 1.0 / LIVELIEST**2)
    factor = samples.per_sample / step_s**6
    size = samples.size
    rough = np.zeros((4, size))
    for i in range(4):
        for j in range(i, 4):
            rough[j - i, i : size - 3 + i] += factor * _THIRD[i] * _THIRD[j] * third
    first = 1.0 / (_PACE_S * step_s * _FASTER**2 * 0.5 * (lively[1:] + lively[:-1]))
    if samples.at_rest:
        first[[0, 1, -2, -1]] += 1.0 / (_REST_RAD_S * step_s) ** 2
    pace = np.zeros((4, size))
    pace[0, :-1] += first
    pace[0, 1:] += first
    pace[1, :-1] -= first
    return replace(samples, roughness=rough, pace=pace)


@dataclass(frozen=True, slots=True)
class Solved:
    """The best path for one smoothness.

    Attributes:
        path: Angles on the grid, shape (K, n).
        spread: Logarithm of the determinant of the information.
        loss: How badly this smoothness explains the samples: -2 log of its evidence, up to a constant.
    """

    path: Float64
    spread: float
    loss: float


class DigitProblem:
    """What the samples say of a digit, ready to be solved for one smoothness or another.

    Args:
        samples: Where they lie.
        information: A_i, shape (N, n, n).
        pull: b_i, shape (N, n).
    """

    def __init__(self, samples: GridSamples, information: Float64, pull: Float64) -> None:
        self._samples = samples
        self._joints = pull.shape[1]
        self._band = self._spread(information)
        late, early = samples.share[:, None], 1.0 - samples.share[:, None]
        right = _gathered(samples.left, early * pull, samples.size)
        right += _gathered(samples.left + 1, late * pull, samples.size)
        self._right = right.ravel()
        self._prior_spreads: dict[float, float] = {}

    def solve(self, jerk_rad_s3: Float64) -> Solved:
        """The best path for one smoothness.

        Args:
            jerk_rad_s3: Usual jerk of each joint, shape (n,).

        Raises:
            Refused: The samples leave a joint undetermined.
        """
        band = self._band.copy()
        n, bottom = self._joints, 3 * self._joints
        known = 0.0
        for joint, jerk in enumerate(jerk_rad_s3):
            prior = self._samples.roughness / jerk**2 + self._samples.pace
            for off in range(4):
                band[bottom - off * n, (off * n + joint) :: n] += prior[off, : self._samples.size - off]
            known -= self._prior_spread(float(jerk), prior)
        try:
            factor = cholesky_banded(band, overwrite_ab=True, check_finite=False)
        except LinAlgError as error:
            raise Refused("take", "without enough samples", "every joint seen", "record it again") from error
        path: Float64 = cho_solve_banded((factor, False), self._right, check_finite=False)
        spread = 2.0 * float(np.log(factor[bottom]).sum())
        return Solved(path.reshape(-1, n), spread, spread + known - float(self._right @ path))

    def _prior_spread(self, jerk_rad_s3: float, prior: Float64) -> float:
        """Logarithm of the determinant of one joint's prior, worked out once for each jerk."""
        if jerk_rad_s3 not in self._prior_spreads:
            prior[0] += _LOOSE
            factor = cholesky_banded(prior, lower=True, overwrite_ab=True, check_finite=False)
            self._prior_spreads[jerk_rad_s3] = 2.0 * float(np.log(factor[0]).sum())
        return self._prior_spreads[jerk_rad_s3]

    def freedom(self, jerk_rad_s3: Float64) -> float:
        """How many of the samples' numbers a path of this smoothness can follow."""
        lower, upper = self.solve(jerk_rad_s3 * np.exp(-_NUDGE)), self.solve(jerk_rad_s3 * np.exp(_NUDGE))
        return self._right.size + (upper.spread - lower.spread) / (4.0 * _NUDGE)

    def usual_jerk(self, start_rad_s3: Float64, *, one_by_one: bool) -> Float64:
        """The jerk of each joint that explains the samples best.

        Args:
            start_rad_s3: Where to begin, shape (n,).
            one_by_one: Whether each joint has its own; else all keep their ratios.
        """
        n = self._joints
        jerk, loss = start_rad_s3.copy(), self.solve(start_rad_s3).loss
        for which in (np.ones(n), *(np.eye(n) if one_by_one else ())):
            jerk, loss = self._along(jerk, loss, which)
        return jerk

    def _along(self, jerk: Float64, loss: float, which: Float64) -> tuple[Float64, float]:
        """The best jerk that differs by powers of two in some joints."""
        for factor in (2.0, 0.5):
            moved = False
            while True:
                tried = np.clip(jerk * factor**which, *JERKS_RAD_S3)
                found = self.solve(tried).loss
                if found > loss - _GAIN:
                    break
                jerk, loss, moved = tried, found, True
            if moved:
                break
        return jerk, loss

    def _spread(self, information: Float64) -> Float64:
        """The samples' information as an upper band with its diagonal last, shape (3 n + 1, K n)."""
        late, early = self._samples.share[:, None, None], 1.0 - self._samples.share[:, None, None]
        left, n, size = self._samples.left, self._joints, self._samples.size
        same = _gathered(left, early**2 * information, size) + _gathered(
            left + 1, late**2 * information, size
        )
        next_ = _gathered(left, early * late * information, size)[:-1]
        band = np.zeros((3 * n + 1, size * n))
        for i in range(n):
            for j in range(n):
                if i <= j:
                    band[3 * n + i - j, j::n] += same[:, i, j]
                band[2 * n + i - j, (n + j) :: n] += next_[:, i, j]
        return band


def _gathered(at: Int64, values: Float64, size: int) -> Float64:
    """Sums of the values (N, ...) that fall on each of some grid points, shape (size, ...)."""
    width = values[0].size
    flat = (at[:, None] * width + np.arange(width)).ravel()
    sums = np.asarray(np.bincount(flat, values.ravel(), size * width), dtype=np.float64)
    return sums.reshape(size, *values.shape[1:])
