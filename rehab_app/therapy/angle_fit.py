"""A smooth movement through fitted postures: every posture counts by its whole covariance.

The joints of a digit err together (near the straight finger MCP and PIP flexion trade off): with their
covariances as weights, what the postures say together is kept, where joint-by-joint smoothing throws it away.
How smooth each joint is, and how far the stated covariances are to be believed, the take itself says.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from rehab_app.therapy.digit_fit import (
    BRIDGE_STD_RAD,
    DIGIT_JOINTS,
    FIRST_TURNS,
    TIPS,
    Bool,
    calm_speed,
    first_weight,
    last_weight,
)
from rehab_app.therapy.grid_fit import DigitProblem, GridSamples, on_grid, paced
from robot_iface.kinematics import HandGeometry, forward
from sessions.records.fields import Float64, Int64

_STD_FLOOR_RAD = float(np.deg2rad(0.1))
_UNSEEN_STD_RAD = 50.0
_FIRST_JERK = 60.0
_TURNS = 12
_LEARN_TURNS = (1, 3, 5)
_LEAST_WEIGHT = 0.02  # a posture that all others deny: a hand is somewhere even then
_SCALES = (0.3, 3.0)  # by how much the stated standard deviations may be wrong
_MIDDLE_S = 0.4  # over which the middle posture is a first guess
_STEP_RAD = 3e-4


def fit_angles(
    t_s: Float64,
    joints_rad: Float64,
    covariance_rad2: Float64,
    geometry: HandGeometry,
    grid_s: Float64,
    *,
    jerk_rad_s3: float | None = None,
    at_rest: bool = True,
) -> Float64:
    """Fit a smooth movement to postures.

    Args:
        t_s: Sample times, rising, shape (N,).
        joints_rad: Angles, NaN in gaps, shape (N, 21).
        covariance_rad2: Their covariances, NaN in gaps, shape (N, 21, 21).
        geometry: The hand; it tells how fast each fingertip moves.
        grid_s: Uniform grid that covers the samples, shape (K,), K >= 8.
        jerk_rad_s3: Usual jerk of every joint: smaller is smoother. None finds it out joint by joint.
        at_rest: Whether the hand stands still at both ends of the grid.

    Returns:
        Angles on the grid, shape (K, 21); 0 for joints never seen.
    """
    samples = on_grid(t_s, grid_s, at_rest=at_rest)
    fits: list[_DigitAngles] = []
    for digit, joints in enumerate(DIGIT_JOINTS):
        shown = joints[np.logical_or.reduce(np.isfinite(joints_rad[:, joints]), axis=0)]
        if shown.size:
            inside = np.ix_(np.arange(t_s.size), shown, shown)
            fits.append(
                _DigitAngles(
                    digit, shown, samples, joints_rad[:, shown], covariance_rad2[inside], jerk_rad_s3
                )
            )
    path = np.zeros((grid_s.size, joints_rad.shape[1]))
    for turn in range(_TURNS):
        moving = [fit for fit in fits if fit.open]
        if not moving:
            break
        tips_m = forward(geometry, path).landmarks_m[:, TIPS]
        for fit in moving:
            if turn > 0:
                fit.pace(tips_m[:, fit.digit] / float(geometry.bones_m[fit.digit].sum()))
            path[:, fit.joints] = fit.step(turn)
    return path


class _DigitAngles:
    """One digit's postures, and the path through them."""

    def __init__(
        self,
        digit: int,
        joints: Int64,
        samples: GridSamples,
        q: Float64,
        covariance: Float64,
        jerk_rad_s3: float | None,
    ) -> None:
        self.digit, self.joints = digit, joints
        self.open = True
        self._samples = samples
        seen: Bool = np.isfinite(q)
        self._target, self._sure = _bridged(q, seen), _information(covariance, seen)
        self._gaps = (~seen) / BRIDGE_STD_RAD**2
        self._whole = np.logical_or.reduce(seen, axis=1).astype(np.float64)
        self._numbers = seen.sum(axis=1)
        self._scale = 1.0
        self._learns = jerk_rad_s3 is None
        self._jerk: Float64 = np.full(joints.size, _FIRST_JERK if jerk_rad_s3 is None else jerk_rad_s3)
        wide = max(3, round(_MIDDLE_S * samples.per_second))
        self._read: Float64 = median_filter(self._target, (wide, 1), mode="nearest")
        self._weight = self._whole * first_weight(self._far(self._read), samples)

    def pace(self, tip: Float64) -> None:
        """Let the digit be as calm as its tip (K, 3), in lengths of the digit, is."""
        if self._learns:
            self._samples = paced(self._samples, calm_speed(tip, self._samples.t_s))

    def step(self, turn: int) -> Float64:
        """A better path, shape (K, n)."""
        problem = self._problem()
        if self._learns and turn in _LEARN_TURNS:
            self._jerk = problem.usual_jerk(self._jerk, one_by_one=turn > _LEARN_TURNS[0])
            far = self._far(self._samples.read(problem.solve(self._jerk).path))
            numbers = float(self._weight @ self._numbers)
            free = max(numbers - problem.freedom(self._jerk), 0.2 * numbers)
            self._scale *= float(np.sqrt(self._weight @ far**2 / free))
            self._scale = float(np.clip(self._scale, *_SCALES))
            problem = self._problem()
        path = problem.solve(self._jerk).path
        before, self._read = self._read, self._samples.read(path)
        far = self._far(self._read)
        # far from a path of a smoothness that was ordered, a posture need not be wrong
        early = turn < FIRST_TURNS or not self._learns
        weight = first_weight(far, self._samples) if early else last_weight(far)
        self._weight = self._whole * np.maximum(weight, _LEAST_WEIGHT)
        moved = float(np.abs(self._read - before).max())
        self.open = turn <= (_LEARN_TURNS[-1] if self._learns else 1) or moved > _STEP_RAD
        return path

    def _far(self, read: Float64) -> Float64:
        """Distance of each posture from a path, in standard deviations, shape (N,)."""
        apart = read - self._target
        return np.sqrt(np.einsum("ni,nij,nj->n", apart, self._sure, apart)) / self._scale

    def _problem(self) -> DigitProblem:
        information = self._sure * (self._weight / self._scale**2)[:, None, None]
        n = self.joints.size
        information[:, range(n), range(n)] += self._gaps
        return DigitProblem(self._samples, information, (information @ self._target[..., None])[..., 0])


def _bridged(q: Float64, seen: Bool) -> Float64:
    """Angles with straight lines across their gaps, joint by joint."""
    rows = np.arange(len(q))
    return np.stack(
        [np.interp(rows, rows[known], column[known]) for column, known in zip(q.T, seen.T, strict=True)],
        axis=1,
    )


def _information(covariance: Float64, seen: Bool) -> Float64:
    """Inverse covariances (N, n, n); an unseen joint says nothing."""
    both = seen[:, :, None] & seen[:, None, :]
    whole = np.where(both & np.isfinite(covariance), covariance, 0.0)
    n = seen.shape[1]
    known = np.isfinite(covariance[:, range(n), range(n)])
    whole[:, range(n), range(n)] += np.where(seen & known, _STD_FLOOR_RAD**2, _UNSEEN_STD_RAD**2)
    return np.linalg.inv(whole)
