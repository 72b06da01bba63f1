"""The shape of one person's hand and the places of the markers on it, from many poses together.

Unknowns of the shape, in this order: logarithm of the size (1), of each bone beside it (15), shift of each
digit's base (15), small turn of each digit's base (15), height of all markers over the bones (1), marker
offsets (3 M). Every one has a prior: the proportions of average hands, the protocol's placing tolerance. The
poses are eliminated frame by frame (Schur complement): the normal equations stay as small as the shape.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.geometry.rotation import turn
from rehab_app.hand.marker_model import MarkerModel, PlacedMarkers, cross
from rehab_app.hand.pose_problem import PoseProblem, PoseState
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from robot_iface.kinematics import HandGeometry
from sessions.records.fields import Float64

_HEIGHT = 46
_OWN = 47  # unknowns before the marker offsets
_SIZE_STD = 0.10
_BONE_STD = 0.08
_BASE_STD_M = np.array([[0.006, 0.006, 0.006], *([[0.003, 0.003, 0.004]] * 4)])
_KNOWN_SHARE = 0.25
_HEIGHT_STD_M = 0.0015  # people are thicker or thinner, and a protocol's word on it is a guess
_TURN_STD_RAD = np.array([[0.3, 0.3, 0.3], *([[0.08, 0.05, 0.08]] * 4)])


@dataclass(frozen=True, slots=True)
class ShapePrior:
    """Where the shape starts and how far it may go.

    Attributes:
        subject: Shape at zero unknowns.
        protocol: The markers.
        std: Standard deviation of each unknown, shape (47 + 3 M,).
    """

    subject: Subject
    protocol: MarkerProtocol
    std: Float64

    @classmethod
    def around(cls, subject: Subject, protocol: MarkerProtocol) -> ShapePrior:
        """The prior around a subject of average proportions."""
        own = [[_SIZE_STD], [_BONE_STD] * 15, _BASE_STD_M.ravel(), _TURN_STD_RAD.ravel(), [_HEIGHT_STD_M]]
        return cls(subject, protocol, np.concatenate([*own, protocol.offset_stds_m.ravel()]))

    @classmethod
    def known(cls, subject: Subject, protocol: MarkerProtocol) -> ShapePrior:
        """The prior around a person measured before: the bones stay, the markers were stuck on anew."""
        prior = cls.around(subject, protocol)
        std = prior.std.copy()
        std[:_HEIGHT] *= _KNOWN_SHARE
        return cls(subject, protocol, std)

    def model(self, shape: Float64) -> MarkerModel:
        """The markers on the hand of a shape (47 + 3 M,)."""
        mean = self.subject.geometry
        size = float(np.exp(shape[0]))
        geometry = HandGeometry(
            mean.side,
            size * (mean.bases_m + shape[16:31].reshape(5, 3)),
            turn(shape[31:46].reshape(5, 3)) @ mean.base_rotation,
            size * mean.bones_m * np.exp(shape[1:16].reshape(5, 3)),
            size * mean.palm_m,
        )
        offsets = self.subject.marker_offset_m + shape[_OWN:].reshape(-1, 3)
        offsets[:, 0] += shape[_HEIGHT]
        return MarkerModel(Subject(geometry, self.subject.marker_names, offsets), self.protocol)


def shape_jacobian(model: MarkerModel, placed: PlacedMarkers, size: float) -> Float64:
    """Derivative of the placed markers in the shape, shape (N, M, 3, 47 + 3 M).

    Base turns are small turns before the present base rotation, exact at the point of linearisation.
    """
    frames, markers = placed.p_m.shape[:2]
    result = np.zeros((frames, markers, 3, _OWN + 3 * markers))
    result[..., 0] = placed.frames.landmarks_m[:, model.anchors]
    bones = placed.frames.rotations[..., 2] * model.right.bones_m[:, :, None]
    for marker, anchor in enumerate(model.anchors):
        own = slice(_OWN + 3 * marker, _OWN + 3 * marker + 3)
        result[:, marker, :, own] = placed.segments[:, model.segments[marker]]
        result[:, marker, :, _HEIGHT] = placed.segments[:, model.segments[marker], :, 0]
        if anchor >= 20:
            continue
        digit, part = divmod(int(anchor), 4)
        first = 1 + 3 * digit
        result[:, marker, :, first : first + part] = np.swapaxes(bones[:, digit, :part], 1, 2)
        result[:, marker, :, 15 + first : 18 + first] = size * np.eye(3)
        if model.digit[marker] >= 0:
            arm = placed.p_m[:, marker] - model.right.bases_m[digit]
            turned = cross(np.eye(3), arm[:, None])
            result[:, marker, :, 30 + first : 33 + first] = np.swapaxes(turned, 1, 2)
    return result


@dataclass(frozen=True, slots=True)
class Bundle:
    """Shape and poses together.

    Attributes:
        prior: Prior of the shape.
        problem: Markers seen; its model is replaced as the shape moves.
        trust: Factor on the information of the frames about the shape: skin moves alike in all of them, so K
            frames do not tell K times as much as one.
    """

    prior: ShapePrior
    problem: PoseProblem
    trust: float

    def with_shape(self, shape: Float64) -> PoseProblem:
        """The pose problem of a hand of this shape."""
        seen = self.problem
        return replace(seen, model=self.prior.model(shape))

    def cost(self, shape: Float64, state: PoseState) -> float:
        """Cost of the poses, as far as trusted, and of the shape."""
        poses = float(self.with_shape(shape).cost(state).sum())
        return self.trust * poses + 0.5 * float(np.sum((shape / self.prior.std) ** 2))

    def step(self, shape: Float64, state: PoseState, damping: float) -> tuple[Float64, Float64]:
        """Damped Gauss-Newton step of shape (47 + 3 M,) and poses (N, 28)."""
        reduced, right, solved = self._reduced(shape, state, damping)
        step: Float64 = np.asarray(np.linalg.solve(reduced, right), dtype=np.float64)
        return step, solved[..., -1] - solved[..., :-1] @ step

    def covariance(self, shape: Float64, state: PoseState) -> Float64:
        """Covariance of the shape when no pose is known, shape (47 + 3 M, 47 + 3 M)."""
        return np.asarray(np.linalg.inv(self._reduced(shape, state, 0.0)[0]), dtype=np.float64)

    def sensitivity(self, shape: Float64, state: PoseState) -> Float64:
        """By how much the best poses follow a change of the shape, shape (N, 28, 47 + 3 M)."""
        problem = self.with_shape(shape)
        information, _, weight = problem.linearised(state)
        mixed, _, _ = self._shape_parts(problem, shape, state, weight)
        total = information + problem.prior_information(state)
        return -np.asarray(np.linalg.solve(total, mixed), dtype=np.float64)

    def _reduced(self, shape: Float64, state: PoseState, damping: float) -> tuple[Float64, Float64, Float64]:
        """Normal equations of the shape alone (S, S), (S,); the poses' part of it (N, 28, S + 1)."""
        problem = self.with_shape(shape)
        information, downhill, weight = problem.linearised(state)
        own = information + problem.prior_information(state)
        own[:, range(28), range(28)] *= 1.0 + damping
        mixed, shapes, pull = self._shape_parts(problem, shape, state, weight)
        shapes = self.trust * shapes + np.diag(1.0 / self.prior.std**2)
        shapes[range(len(shape)), range(len(shape))] *= 1.0 + damping
        right = np.concatenate([mixed, downhill[..., None]], axis=2)
        solved: Float64 = np.asarray(np.linalg.solve(own, right), dtype=np.float64)
        flat = mixed.reshape(-1, len(shape))
        told = flat.T @ solved.reshape(len(flat), -1)
        reduced = shapes - self.trust * told[:, :-1]
        return reduced, self.trust * (pull - told[:, -1]) - shape / self.prior.std**2, solved

    def _shape_parts(
        self, problem: PoseProblem, shape: Float64, state: PoseState, weight: Float64
    ) -> tuple[Float64, Float64, Float64]:
        """Information between poses and shape (N, 28, S), of the shape (S, S), and its downhill (S,)."""
        placed, arms = problem.predicted(state)
        frames = len(arms)
        to_camera = state.rotation * problem.model.mirror * np.exp(state.log_size)[:, None, None]
        slopes = to_camera[:, None] @ shape_jacobian(problem.model, placed, float(np.exp(shape[0])))
        slopes = problem.along_axes(slopes).reshape(frames, -1, len(shape))
        trusted = (problem.precision * weight[..., None]).reshape(frames, -1)
        weighted = slopes * trusted[..., None]
        mixed = np.swapaxes(problem.jacobian(state, placed, arms), 1, 2) @ weighted
        residual = problem.residuals(state).reshape(frames, -1)
        flat = slopes.reshape(-1, len(shape))
        return mixed, weighted.reshape(-1, len(shape)).T @ flat, np.einsum("nrs,nr->s", weighted, residual)
