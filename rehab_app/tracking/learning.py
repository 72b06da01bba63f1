"""The person's hand, learnt while tracked: at once from the first capture, then with every new posture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.bundle import Bundle, ShapePrior
from rehab_app.hand.calibration import minimised, sized, trust_in
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import rest_prior
from rehab_app.hand.pose_problem import PoseProblem, PoseState
from rehab_app.hand.pose_solver import solve_from_nothing
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from rehab_app.tracking.evidence import Evidence, stacked
from rehab_app.tracking.hand_state import POSITIONS, HandState
from sessions.records import Side
from sessions.records.fields import Float64

_MOST = 40  # captures kept
_STILL = 5  # captures of the same posture that are kept at the beginning
_APART_S = 0.1  # captures kept are at least as far apart
_NEW_RAD = 0.25  # a posture is new when some joint differs by as much from every one kept
_WAYMARKS = (3, 5, 8, 12, 18, 26, 40)  # numbers of captures after which the hand is fitted anew
_ROUNDS_FIRST = 30
_ROUNDS = 6
_SETTLE_S = 0.7  # in which the model moves to what was learnt: joints must not jump
_SHARE_SEEN = 0.6
_FLOOR_EVERY = 15
_LEAST_WOBBLE_M = 0.0025  # skin is never stiffer


@dataclass(frozen=True, slots=True)
class Kept:
    """One capture that the hand is learnt from."""

    evidence: Evidence
    pose: PoseState


class Learning:
    """Learns one person's hand.

    Args:
        protocol: The markers.
        side: Side of the hand.
        subject: The person, if known already: only the markers' places are learnt then, bones hardly.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side, subject: Subject | None = None) -> None:
        self._protocol = protocol
        self._side: Side = side
        self._prior = None if subject is None else ShapePrior.known(subject, protocol)
        self._kept: list[Kept] = []
        self._goal: Float64 = np.zeros(0)
        self._shape: Float64 = np.zeros(0)
        self._covariance: Float64 = np.zeros((0, 0))
        self._since_s = 0.0
        self._wobble_m2 = protocol.noise_m**2
        self._floor: Float64 = np.zeros((21, 21))
        self._floor_age = 0
        self.model: MarkerModel | None = None if self._prior is None else self._begun(self._prior)

    @property
    def postures_rad(self) -> Float64:
        """Different postures that the hand took, shape (K, 21)."""
        if not self._kept:
            return np.zeros((0, 21))
        return np.concatenate([kept.pose.joints_rad for kept in self._kept[:1] + self._kept[_STILL:]])

    def first(self, seen: Evidence) -> PoseState:
        """The hand in the first capture whose markers have names; of an unknown person, the person as well.

        Raises:
            Refused: What was seen is no human hand.
        """
        if self._prior is None:
            subject, pose = sized(seen.p_m, self._protocol, self._side, seen.precision(0.0), seen.axes)
            self._prior = ShapePrior.around(subject, self._protocol)
            self.model = self._begun(self._prior)
        else:
            pose = solve_from_nothing(self._problem(seen))
        self._kept.append(Kept(seen, pose))
        return self._fitted(_ROUNDS_FIRST, at_once=True)

    def feed(self, state: HandState, seen: Evidence, span_s: float, wobble_m2: float) -> None:
        """Take a tracked capture; now and then the hand is fitted anew.

        Args:
            state: The hand.
            seen: The markers.
            span_s: Time since the last capture.
            wobble_m2: Variance of a marker's place on its bone, as far as known.
        """
        self._wobble_m2 = max(wobble_m2, _LEAST_WOBBLE_M**2)
        self._settle(span_s)
        self._since_s += span_s
        if len(self._kept) >= _MOST or not self._worth(state, seen):
            return
        self._since_s = 0.0
        pose = PoseState(state.rotation[None], state.p_m[None], state.joints_rad[None], np.zeros(1))
        self._kept.append(Kept(seen, pose))
        if len(self._kept) in _WAYMARKS:
            self._fitted(_ROUNDS, at_once=len(self._kept) <= _STILL)

    def floor_rad2(self, state: HandState, seen: Evidence) -> Float64:
        """Covariance of the joints that comes of not knowing the hand exactly, shape (21, 21).

        It changes slowly with the posture and is worked out for every few captures only.
        """
        if self._floor_age % _FLOOR_EVERY == 0 and self._covariance.size:
            self._floor = self._floor_of(state, seen)
        self._floor_age += 1
        return self._floor

    def _floor_of(self, state: HandState, seen: Evidence) -> Float64:
        """By how much the best pose moves when the shape moves within its covariance."""
        assert self._prior is not None
        pose = PoseState(state.rotation[None], state.p_m[None], state.joints_rad[None], np.zeros(1))
        problem = self._problem(seen)
        bundle = Bundle(self._prior, problem, 1.0)
        moved = bundle.sensitivity(self._shape, pose)[0, 6:27]
        return moved @ self._covariance @ moved.T

    def _begun(self, prior: ShapePrior) -> MarkerModel:
        self._goal = self._shape = np.zeros(len(prior.std))
        return prior.model(self._shape)

    def _worth(self, state: HandState, seen: Evidence) -> bool:
        if np.isfinite(seen.p_m[0, :, 0]).mean() < _SHARE_SEEN:
            return False
        if self._since_s < _APART_S:
            return False
        if len(self._kept) < _STILL:
            return True
        std = np.sqrt(np.diagonal(state.covariance)[6:POSITIONS])
        known = std < 0.5 * _NEW_RAD
        postures = np.concatenate([kept.pose.joints_rad for kept in self._kept])
        return bool((np.abs(postures - state.joints_rad)[:, known].max(axis=1, initial=0.0) > _NEW_RAD).all())

    def _settle(self, span_s: float) -> None:
        """Move the model towards what was learnt."""
        if self._prior is None or self._shape is self._goal:
            return
        left = self._goal - self._shape
        share = min(span_s / _SETTLE_S, 1.0)
        self._shape = self._shape + share * left
        if float(np.abs(left / self._prior.std).max()) < 0.01:
            self._shape = self._goal
        self.model = self._prior.model(self._shape)

    def _fitted(self, rounds: int, *, at_once: bool) -> PoseState:
        """Fit the hand to everything kept; the poses of it."""
        assert self._prior is not None
        seen = stacked([kept.evidence for kept in self._kept])
        problem = self._problem(seen)
        bundle = Bundle(self._prior, problem, trust_in(len(self._kept)))
        shape, poses = minimised(bundle, self._goal, _joined([kept.pose for kept in self._kept]), rounds)
        self._goal = shape
        self._covariance = bundle.covariance(shape, poses)
        self._floor_age = 0
        self._kept = [Kept(kept.evidence, poses.at(np.array([row]))) for row, kept in enumerate(self._kept)]
        if at_once:
            self._shape = shape
            self.model = self._prior.model(shape)
        return self._kept[-1].pose

    def _problem(self, seen: Evidence) -> PoseProblem:
        assert self.model is not None
        return PoseProblem(
            self.model,
            np.nan_to_num(seen.p_m),
            seen.precision(self._wobble_m2),
            rest_prior(len(seen.p_m)),
            seen.axes,
            1.0 / len(seen.p_m),
        )


def _joined(poses: list[PoseState]) -> PoseState:
    return PoseState(
        np.concatenate([pose.rotation for pose in poses]),
        np.concatenate([pose.p_m for pose in poses]),
        np.concatenate([pose.joints_rad for pose in poses]),
        np.concatenate([pose.log_size for pose in poses]),
    )
