"""Levenberg-Marquardt over many frames at once; a frame that has converged leaves the batch."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.rotation import rigid_fit
from rehab_app.hand.pose_prior import starting_postures
from rehab_app.hand.pose_problem import PoseProblem, PoseState
from sessions.records.fields import Float64

_BATCH = 512  # frames whose derivatives fit the processor's cache together
_STEP_RAD = 2e-5  # step below which a frame has converged, rad and m alike
_COARSE = 8  # of a recording, every so many frames are fitted from nothing, the others from these
_SUSPECT = 4.0  # times the median cost: the fit may sit in a side valley and is tried again from nothing


def solve(problem: PoseProblem, start: PoseState, iterations: int = 40) -> tuple[PoseState, Float64]:
    """The poses of least cost near a start, and their costs (N,)."""
    frames = len(start.p_m)
    state = PoseState(start.rotation.copy(), start.p_m.copy(), start.joints_rad.copy(), start.log_size.copy())
    cost = np.empty(frames)
    for first in range(0, frames, _BATCH):
        rows = np.arange(first, min(first + _BATCH, frames))
        part, cost[rows] = _solve_batch(problem.at(rows), state.at(rows), iterations)
        state.put(rows, part)
    return state, cost


def solve_from_nothing(problem: PoseProblem) -> PoseState:
    """The poses of least cost without a start: some frames, then their neighbours, doubts again."""
    frames = len(problem.p_m)
    coarse = np.arange(0, frames, _COARSE if frames > 4 * _COARSE else 1)
    state, cost = _solve_from_postures(problem.at(coarse))
    if len(coarse) < frames:
        nearest = np.minimum((np.arange(frames) + _COARSE // 2) // _COARSE, len(coarse) - 1)
        state, cost = solve(problem, state.at(nearest))
    suspects = np.flatnonzero(cost > _SUSPECT * np.median(cost))
    if suspects.size:
        again, lower = _solve_from_postures(problem.at(suspects))
        better = lower < cost[suspects]
        state.put(suspects[better], again.at(np.flatnonzero(better)))
    return state


def posed_start(problem: PoseProblem, posture_rad: Float64) -> PoseState:
    """The palm laid so that a hand in one posture (21,) comes nearest to the markers seen."""
    model, frames = problem.model, len(problem.p_m)
    template = model.positions(posture_rad)
    rotation, p_m = rigid_fit(problem.p_m, template, problem.precision.mean(axis=2))
    return PoseState(rotation, p_m, np.tile(posture_rad, (frames, 1)), np.zeros(frames))


def _solve_from_postures(problem: PoseProblem) -> tuple[PoseState, Float64]:
    """The best of the fits that begin from each starting posture."""
    best, lowest = solve(problem, posed_start(problem, starting_postures()[0]))
    for posture in starting_postures()[1:]:
        state, cost = solve(problem, posed_start(problem, posture))
        better = np.flatnonzero(cost < lowest)
        best.put(better, state.at(better))
        lowest = np.minimum(cost, lowest)
    return best, lowest


def _solve_batch(problem: PoseProblem, state: PoseState, iterations: int) -> tuple[PoseState, Float64]:
    cost = problem.cost(state)
    damping = np.full(len(cost), 1e-3)
    active = np.arange(len(cost))
    for _ in range(iterations):
        part, here = problem.at(active), state.at(active)
        step = _step(part, here, damping[active])
        trial = here.moved(step)
        trial_cost = part.cost(trial)
        better = trial_cost < cost[active]
        rows = active[better]
        state.put(rows, trial.at(np.flatnonzero(better)))
        gain = cost[active] - trial_cost
        cost[rows] = trial_cost[better]
        damping[active] = np.clip(damping[active] * np.where(better, 0.1, 10.0), 1e-9, 1e9)
        moving = np.abs(step).max(axis=1) > _STEP_RAD
        progress = ~better | (gain > 1e-5 * (1.0 + trial_cost))
        active = active[moving & progress & (damping[active] < 1e6)]
        if not active.size:
            break
    return state, cost


def _step(problem: PoseProblem, state: PoseState, damping: Float64) -> Float64:
    information, downhill, _ = problem.linearised(state)
    matrix = information + problem.prior_information(state)
    diagonal = matrix[:, range(matrix.shape[1]), range(matrix.shape[1])]
    matrix[:, range(matrix.shape[1]), range(matrix.shape[1])] += damping[:, None] * diagonal
    return np.asarray(np.linalg.solve(matrix, downhill[..., None])[..., 0], dtype=np.float64)
