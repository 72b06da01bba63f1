"""One digit of a fit to positions: robust weights, noise, smoothness and Gauss-Newton steps."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import median_filter, uniform_filter1d

from rehab_app.hand.pose_prior import coupling_precision, rest_prior
from rehab_app.therapy.grid_fit import DigitProblem, GridSamples, paced
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD
from sessions.records import DIGITS, JOINTS, LANDMARKS, digit_of
from sessions.records.fields import Float64, Int64

Bool = npt.NDArray[np.bool_]

HUBER = 3.0
"""Distance of a sample from the path, in standard deviations, from which its pull falls (first steps)."""
CUT = 7.0
"""Distance from which it has no say at all (last steps)."""

BRIDGE_STD_RAD = 0.4
"""How surely a gap lies on the line between its ends: hardly; it keeps a lively bridge from running away."""

FIRST_TURNS = 4
"""Steps after which the path counts as known."""

_FIRST_STD_M = 2e-3
_LEAST_STD_M = 1e-4
_FIRST_JERK = 60.0
_LIMIT_STD_RAD = 0.02
_NEIGHBOURS_S = 0.8
_LEARN_TURNS = (1, 3, 5)
_CALM_S = 0.2
_STEP_RAD = 5e-4
DIGIT_JOINTS: tuple[Int64, ...] = tuple(
    np.array([row for row, joint in enumerate(JOINTS) if digit_of(joint) == digit]) for digit in DIGITS
)
DIGIT_LANDMARKS: tuple[Int64, ...] = tuple(
    np.array([row for row, name in enumerate(LANDMARKS) if digit_of(name) == digit][1:]) for digit in DIGITS
)
TIPS: Int64 = np.array([marks[-1] for marks in DIGIT_LANDMARKS])
_REST = rest_prior(1)
_HABIT = coupling_precision() + np.diag(1.0 / _REST.std_rad**2)


def first_weight(far: Float64, samples: GridSamples) -> Float64:
    """Weights before the path is known: what stands off more than its own neighbourhood counts little.

    While the path is still too smooth for a quick movement, all samples of it stand off, and none is wrong;
    a swapped marker stands off alone.

    Args:
        far: Distance of each sample from the path in standard deviations, shape (N,) or (N, m).
        samples: Where the samples lie.
    """
    wide = max(3, round(_NEIGHBOURS_S * samples.per_second))
    usual = median_filter(far, (wide, *(1 for _ in far.shape[1:])), mode="nearest")
    weight: Float64 = (HUBER / np.maximum(far / np.maximum(usual, 1.0), HUBER)) ** 2
    return weight


def last_weight(far: Float64) -> Float64:
    """Weights once the path is known: none for what is far from it."""
    weight: Float64 = np.maximum(1.0 - (far / CUT) ** 2, 0.0) ** 2
    return weight


def calm_speed(tip: Float64, t_s: Float64) -> Float64:
    """Speed of a fingertip over a fifth of a second, rms.

    Args:
        tip: The tip in lengths of its digit, shape (N, 3).
        t_s: Times, shape (N,).

    Returns:
        About the speed of the joints behind it, shape (N,), rad/s.
    """
    wide = max(3, round(_CALM_S * t_s.size / float(t_s[-1] - t_s[0])))
    square = (np.gradient(tip, t_s, axis=0) ** 2).sum(axis=1)
    speed: Float64 = np.sqrt(np.maximum(uniform_filter1d(square, wide, mode="nearest"), 0.0))
    return speed


class DigitFit:
    """The state of one digit's fit.

    Args:
        digit: Which.
        samples: Where the samples lie on the grid.
        seen: Which landmarks are seen, shape (N, 25).
        std_m: Standard deviation of a position; None to find it out.
        jerk_rad_s3: Usual jerk; None to find it out.
    """

    def __init__(
        self, digit: int, samples: GridSamples, seen: Bool, std_m: float | None, jerk_rad_s3: float | None
    ) -> None:
        self.joints, self.marks = DIGIT_JOINTS[digit], DIGIT_LANDMARKS[digit]
        self.seen: Bool = seen[:, self.marks]
        self.open = True
        self.path: Float64 = np.zeros((samples.size, self.joints.size))
        self.jerk: Float64 = np.full(self.joints.size, _FIRST_JERK if jerk_rad_s3 is None else jerk_rad_s3)
        self.std_m = _FIRST_STD_M if std_m is None else std_m
        self.weight: Float64 = self.seen.astype(np.float64)
        self._samples = samples
        self._learns_std, self._learns_jerk = std_m is None, jerk_rad_s3 is None
        self._habit = _HABIT[np.ix_(self.joints, self.joints)]
        self._rest = _HABIT[np.ix_(self.joints, self.joints)] @ _REST.joints_rad[0, self.joints]

    def step(self, q: Float64, apart_m: Float64, slopes: Float64, turn: int) -> Float64:
        """One Gauss-Newton step.

        Args:
            q: Angles at the samples, shape (N, n).
            apart_m: Seen minus placed landmarks, shape (N, m, 3).
            slopes: Derivative of the placed ones, shape (N, m, 3, n).
            turn: Counts the steps.

        Returns:
            Better angles at the samples.
        """
        self._weigh(apart_m, turn)
        problem = self._problem(q, apart_m, slopes)
        if turn in _LEARN_TURNS:
            problem = self._learn(problem, q, apart_m, slopes, turn)
        self.path = problem.solve(self.jerk).path
        after = self._samples.read(self.path)
        self.open = turn <= _LEARN_TURNS[-1] or float(np.abs(after - q).max()) > _STEP_RAD
        return after

    def _weigh(self, apart_m: Float64, turn: int) -> None:
        far = np.sqrt((apart_m**2).sum(axis=2)) / self.std_m
        weight = first_weight(far, self._samples) if turn < FIRST_TURNS else last_weight(far)
        self.weight = weight * self.seen

    def _problem(self, q: Float64, apart_m: Float64, slopes: Float64) -> DigitProblem:
        precision = self.weight / self.std_m**2
        scaled = slopes * precision[:, :, None, None]
        frames, n = q.shape
        flat, scaled = slopes.reshape(frames, -1, n), scaled.reshape(frames, -1, n)
        information = np.swapaxes(scaled, 1, 2) @ flat
        pull = (information @ q[..., None])[..., 0]
        pull += (np.swapaxes(scaled, 1, 2) @ apart_m.reshape(frames, -1, 1))[..., 0]
        low, high = JOINT_MIN_RAD[self.joints], JOINT_MAX_RAD[self.joints]
        beyond = ((q < low) | (q > high)) / _LIMIT_STD_RAD**2
        bridge, line = self._bridge(q)
        information += self._habit
        information[:, range(n), range(n)] += beyond + bridge
        pull += self._rest + beyond * np.clip(q, low, high) + bridge * line
        return DigitProblem(self._samples, information, pull)

    def _bridge(self, q: Float64) -> tuple[Float64, Float64]:
        """Precision (N, 1) of a gap lying on the line between its ends, and the line (N, n)."""
        known: Bool = np.logical_or.reduce(self.seen, axis=1)
        rows = np.arange(len(q))
        columns = [np.interp(rows, rows[known], column[known]) for column in q.T]
        return (~known)[:, None] / BRIDGE_STD_RAD**2, np.stack(columns, axis=1)

    def pace(self, tip_m: Float64, reach_m: float, t_s: Float64) -> None:
        """Let the digit be as calm as its tip (N, 3) is."""
        speed = calm_speed(tip_m / reach_m, t_s)
        self._samples = paced(self._samples, np.interp(self._samples.t_s, t_s, speed))

    def _learn(
        self, problem: DigitProblem, q: Float64, apart_m: Float64, slopes: Float64, turn: int
    ) -> DigitProblem:
        """Noise and smoothness, each by the other, at the present linearisation."""
        if self._learns_jerk:
            self.jerk = problem.usual_jerk(self.jerk, one_by_one=turn > _LEARN_TURNS[0])
        if not self._learns_std:
            return problem
        moved = self._samples.read(problem.solve(self.jerk).path) - q
        left_m = apart_m - (slopes @ moved[:, None, :, None])[..., 0]
        squares = float((self.weight[..., None] * left_m**2).sum())
        numbers = 3.0 * float(self.weight.sum())
        free = max(numbers - problem.freedom(self.jerk), 0.2 * numbers)
        self.std_m = max(float(np.sqrt(squares / free)), _LEAST_STD_M)
        return self._problem(q, apart_m, slopes)
