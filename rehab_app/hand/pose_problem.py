"""The least-squares problem of a hand pose: residuals, derivatives, cost; many frames at once.

Unknowns of a frame, in this order (28): a small turn of the palm in the camera frame (3), the palm's origin
(3), the joints (21), the logarithm of the hand's size in this frame (1, held at 0 for real markers).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.geometry.rotation import turn
from rehab_app.hand.marker_model import MarkerModel, PlacedMarkers
from rehab_app.hand.pose_prior import LIMIT_STD_RAD, JointPrior, beyond_limits, coupling_precision
from sessions.records.fields import Float64, Int64

UNKNOWNS = 28
JOINT_PART = slice(6, 27)
HUBER = 3.0
"""Distance of a marker, in standard deviations, from which its pull stops growing."""

_COUPLING = coupling_precision()
_FIXED_SIZE_PRECISION = 1e12


@dataclass(frozen=True, slots=True)
class PoseState:
    """Poses of N frames.

    Attributes:
        rotation: Palm to camera, shape (N, 3, 3).
        p_m: Palm origin in the camera frame, shape (N, 3).
        joints_rad: Joint angles, shape (N, 21).
        log_size: Logarithm of the size factor, shape (N,).
    """

    rotation: Float64
    p_m: Float64
    joints_rad: Float64
    log_size: Float64

    def at(self, rows: Int64) -> PoseState:
        """The poses of some rows."""
        return PoseState(self.rotation[rows], self.p_m[rows], self.joints_rad[rows], self.log_size[rows])

    def moved(self, step: Float64) -> PoseState:
        """The poses after a step in the unknowns, shape (N, 28)."""
        return PoseState(
            turn(step[:, :3]) @ self.rotation,
            self.p_m + step[:, 3:6],
            self.joints_rad + step[:, JOINT_PART],
            self.log_size + step[:, 27],
        )

    def put(self, rows: Int64, other: PoseState) -> None:
        """Overwrite some rows in place."""
        self.rotation[rows], self.p_m[rows] = other.rotation, other.p_m
        self.joints_rad[rows], self.log_size[rows] = other.joints_rad, other.log_size


def placed_arms(model: MarkerModel, state: PoseState) -> tuple[PlacedMarkers, Float64]:
    """Placed markers, and the arms from palm origin to marker in the camera frame, (N, M, 3)."""
    placed = model.place(state.joints_rad)
    grown = placed.p_m * model.mirror * np.exp(state.log_size)[:, None, None]
    return placed, grown @ np.swapaxes(state.rotation, 1, 2)


def marker_slopes(model: MarkerModel, state: PoseState, placed: PlacedMarkers, arms: Float64) -> Float64:
    """Derivative of the markers in the camera frame in the unknowns, shape (N, M, 3, 28)."""
    frames, markers = arms.shape[:2]
    result = np.zeros((frames, markers, 3, UNKNOWNS))
    x, y, z = np.moveaxis(arms, -1, 0)
    result[..., 0, 1], result[..., 0, 2] = z, -y
    result[..., 1, 0], result[..., 1, 2] = -z, x
    result[..., 2, 0], result[..., 2, 1] = y, -x
    result[..., :, 3:6] = np.eye(3)
    to_camera = state.rotation * model.mirror * np.exp(state.log_size)[:, None, None]
    result[..., JOINT_PART] = to_camera[:, None] @ model.right_jacobian(placed)
    result[..., 27] = arms
    return result


@dataclass(frozen=True, slots=True)
class PoseProblem:
    """What was seen in N frames and what was known before.

    Attributes:
        model: The person with the markers.
        p_m: Seen positions in the camera frame, 0 where unseen, shape (N, M, 3).
        precision: 1/variance per axis, 0 where unseen, shape (N, M, 3), m^-2.
        prior: Expected joints.
        axes: Axes (rows) that the precision is stated along, such as a ray and two across it, shape
            (N, M, 3, 3); None for those of the camera.
        habit: Weight of the hand at rest and of the DIP coupling, 0 to 1. Frames of one person stray from
            them alike: many frames together must not count them many times.
    """

    model: MarkerModel
    p_m: Float64
    precision: Float64
    prior: JointPrior
    axes: Float64 | None = None
    habit: float = 1.0

    def at(self, rows: Int64) -> PoseProblem:
        """The problem of some frames."""
        std = self.prior.std_rad if self.prior.std_rad.ndim == 1 else self.prior.std_rad[rows]
        prior = JointPrior(self.prior.joints_rad[rows], std)
        axes = None if self.axes is None else self.axes[rows]
        return PoseProblem(self.model, self.p_m[rows], self.precision[rows], prior, axes, self.habit)

    @property
    def size_precision(self) -> float:
        """1/variance of the logarithm of the size."""
        std = self.model.protocol.size_std
        return 1.0 / std**2 if std > 0 else _FIXED_SIZE_PRECISION

    def predicted(self, state: PoseState) -> tuple[PlacedMarkers, Float64]:
        """Placed markers, and the arms from palm origin to marker in the camera frame, (N, M, 3)."""
        return placed_arms(self.model, state)

    def residuals(self, state: PoseState) -> Float64:
        """Seen minus predicted along the axes, 0 where unseen, shape (N, M, 3), m."""
        _, arms = self.predicted(state)
        return self._residual(state, arms)

    def _residual(self, state: PoseState, arms: Float64) -> Float64:
        apart = self.p_m - arms - state.p_m[:, None]
        if self.axes is not None:
            apart = (self.axes @ apart[..., None])[..., 0]
        return apart * (self.precision > 0)

    def along_axes(self, slopes: Float64) -> Float64:
        """Derivatives (N, M, 3, K) of places in the camera frame as those along the axes."""
        return slopes if self.axes is None else self.axes @ slopes

    def cost(self, state: PoseState) -> Float64:
        """Half of the robust sum of squares in standard deviations, shape (N,)."""
        distance = np.sqrt(np.einsum("nmi,nmi->nm", self.residuals(state) ** 2, self.precision))
        robust = np.where(distance < HUBER, 0.5 * distance**2, HUBER * (distance - 0.5 * HUBER))
        joints = state.joints_rad
        rest = ((joints - self.prior.joints_rad) / self.prior.std_rad) ** 2
        out = (beyond_limits(joints) / LIMIT_STD_RAD) ** 2
        coupled = np.einsum("ni,ij,nj->n", joints, _COUPLING, joints)
        habits = self.habit * (rest.sum(axis=1) + coupled)
        size = self.size_precision * state.log_size**2
        return robust.sum(axis=1) + 0.5 * (habits + out.sum(axis=1) + size)

    def linearised(self, state: PoseState) -> tuple[Float64, Float64, Float64]:
        """Information of the markers alone, gradient of the whole, robust weight of each marker.

        Returns:
            J^T W J (N, 28, 28); J^T W r with the priors' part (N, 28), which points downhill; weights (N, M).
        """
        placed, arms = self.predicted(state)
        residual = self._residual(state, arms)
        distance = np.sqrt(np.einsum("nmi,nmi->nm", residual**2, self.precision))
        weight = HUBER / np.maximum(distance, HUBER)
        jacobian = self.jacobian(state, placed, arms)
        scaled = jacobian * (self.precision * weight[:, :, None]).reshape(len(arms), -1)[:, :, None]
        information = np.swapaxes(scaled, 1, 2) @ jacobian
        downhill = (np.swapaxes(scaled, 1, 2) @ residual.reshape(len(arms), -1, 1))[..., 0]
        joints = state.joints_rad
        rest = (joints - self.prior.joints_rad) / self.prior.std_rad**2
        downhill[:, JOINT_PART] -= self.habit * (rest + joints @ _COUPLING)
        downhill[:, JOINT_PART] -= beyond_limits(joints) / LIMIT_STD_RAD**2
        downhill[:, 27] -= self.size_precision * state.log_size
        return information, downhill, weight

    def jacobian(self, state: PoseState, placed: PlacedMarkers, arms: Float64) -> Float64:
        """Derivative of the predicted markers along the axes in the unknowns, shape (N, 3 M, 28)."""
        slopes = self.along_axes(marker_slopes(self.model, state, placed, arms))
        return slopes.reshape(len(arms), -1, UNKNOWNS)

    def prior_information(self, state: PoseState, *, coupled: bool = True, limited: bool = True) -> Float64:
        """Precision that the priors add, shape (N, 28, 28)."""
        result = np.zeros((len(state.p_m), UNKNOWNS, UNKNOWNS))
        diagonal = np.zeros((len(state.p_m), UNKNOWNS))
        diagonal[:, :6] = 1e-2  # a metre, a turn: keeps what no marker fixes from being singular
        diagonal[:, JOINT_PART] = self.habit / self.prior.std_rad**2
        if limited:
            diagonal[:, JOINT_PART] += (beyond_limits(state.joints_rad) != 0) / LIMIT_STD_RAD**2
        diagonal[:, 27] = self.size_precision
        result[:, range(UNKNOWNS), range(UNKNOWNS)] = diagonal
        if coupled:
            result[:, JOINT_PART, JOINT_PART] += self.habit * _COUPLING
        return result
