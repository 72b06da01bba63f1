"""Joint angles straight from positions: one smooth movement of all fingers, fitted to landmarks with gaps.

Minimises sum w |FK(q(t_i)) - x_i|^2 / s^2 + sum (q''' / jerk)^2 by Gauss-Newton steps, digit by digit (in the
palm frame they share nothing), with Huber weights first and redescending ones then, so that a swapped marker
ends with no say. Positions keep their say where a posture-by-posture inverse loses it: near the straight
finger the tip says little of one posture, but the movement before and after says the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.therapy.digit_fit import DIGIT_LANDMARKS, Bool, DigitFit
from rehab_app.therapy.fit_start import starting_angles
from rehab_app.therapy.grid_fit import on_grid
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, HandGeometry, forward, jacobian
from sessions.errors import Refused
from sessions.records import JOINTS, LANDMARKS
from sessions.records.fields import Float64

_TURNS = 10


@dataclass(frozen=True, slots=True)
class PositionFit:
    """A movement fitted to positions.

    Attributes:
        joints_rad: Angles on the grid, shape (K, 21); NaN for a digit of which nothing was seen.
        std_m: Standard deviation of a position per axis as the fit leaves it, by digit, shape (5,).
        jerk_rad_s3: Usual jerk of each joint that was found or given, shape (21,).
        rejected: Positions seen that ended with no say.
    """

    joints_rad: Float64
    std_m: Float64
    jerk_rad_s3: Float64
    rejected: int


def fit_positions(
    t_s: Float64,
    landmarks_m: Float64,
    geometry: HandGeometry,
    grid_s: Float64,
    *,
    std_m: float | None = None,
    jerk_rad_s3: float | None = None,
    at_rest: bool = False,
) -> PositionFit:
    """Fit joint angles to landmarks.

    Args:
        t_s: Sample times, rising, shape (N,).
        landmarks_m: Landmarks in the palm frame in the order of LANDMARKS, NaN where unseen; fingertips alone
            will do (the DIP joint then follows the PIP joint). Shape (N, 25, 3).
        geometry: The hand.
        grid_s: Uniform grid that covers the samples, shape (K,), K >= 8.
        std_m: Standard deviation of a position per axis; None finds it out.
        jerk_rad_s3: Usual jerk of all joints; None finds it out joint by joint.
        at_rest: Whether the hand stands still at both ends of the grid.

    Returns:
        The fit; angles lie within the anatomical range.

    Raises:
        Refused: No digit is seen, or the shapes do not fit.
    """
    if landmarks_m.shape != (t_s.size, len(LANDMARKS), 3):
        bound = f"({t_s.size}, {len(LANDMARKS)}, 3)"
        raise Refused("landmarks", f"of shape {landmarks_m.shape}", bound, "give 25 landmarks a sample")
    seen: Bool = np.logical_and.reduce(np.isfinite(landmarks_m), axis=2)
    digits = [digit for digit in range(5) if int(seen[:, DIGIT_LANDMARKS[digit]].any(axis=1).sum()) >= 4]
    if not digits:
        raise Refused("landmarks", "without any digit", "positions of one digit or more", "record it again")
    samples = on_grid(t_s, grid_s, at_rest=at_rest)
    fits = {digit: DigitFit(digit, samples, seen, std_m, jerk_rad_s3) for digit in digits}
    _run(fits, t_s, np.where(seen[..., None], landmarks_m, 0.0), seen, geometry)
    return _gathered(fits, grid_s.size)


def _run(fits: dict[int, DigitFit], t_s: Float64, x_m: Float64, seen: Bool, geometry: HandGeometry) -> None:
    """Gauss-Newton steps of all digits together, until each rests."""
    q = starting_angles(geometry, x_m, seen)
    for turn in range(_TURNS):
        moving = [fit for fit in fits.values() if fit.open]
        if not moving:
            return
        x_m_fit = forward(geometry, q).landmarks_m
        apart_m = x_m - x_m_fit
        slopes = jacobian(geometry, q)
        for fit in moving:
            if turn >= 2:
                fit.pace(x_m_fit[:, fit.marks[-1]], float(geometry.bones_m[fit.marks[-1] // 4].sum()), t_s)
            of = np.ix_(np.arange(len(q)), fit.marks, np.arange(3), fit.joints)
            q[:, fit.joints] = fit.step(q[:, fit.joints], apart_m[:, fit.marks], slopes[of], turn)


def _gathered(fits: dict[int, DigitFit], size: int) -> PositionFit:
    path = np.full((size, len(JOINTS)), np.nan)
    std_m, jerk = np.full(5, np.nan), np.full(len(JOINTS), np.nan)
    rejected = 0
    for digit, fit in fits.items():
        low, high = JOINT_MIN_RAD[fit.joints], JOINT_MAX_RAD[fit.joints]
        path[:, fit.joints] = np.clip(fit.path, low, high)
        std_m[digit], jerk[fit.joints] = fit.std_m, fit.jerk
        rejected += int((fit.seen & (fit.weight <= 0.0)).sum())
    return PositionFit(path, std_m, jerk, rejected)
