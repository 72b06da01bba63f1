"""Poses of cameras and boards at once: least squares on the corners, by Levenberg and Marquardt."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.board_pose import matrix_of
from rehab_app.calibration.corners import Corners
from rehab_app.geometry.lens import Lens, camera_matrix
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

_ROUNDS = 50
_SETTLED = 1e-10


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of a camera before its place is: the pinhole and the lens."""

    intrinsics: Intrinsics
    lens: Lens


@dataclass(frozen=True, slots=True)
class RigState:
    """The unknowns: rotation vector and translation of each pose.

    Attributes:
        cameras: ``T_camera_tracking`` of every camera, the first is the identity, shape (C, 6).
        boards: ``T_tracking_board`` of every instant, shape (K, 6).
    """

    cameras: Float64
    boards: Float64


@dataclass(frozen=True, slots=True)
class _Seen:
    """One camera's error at one instant, and how it changes with the camera's and the board's pose."""

    capture: int
    camera: int
    off_px: Float64
    by_camera: Float64
    by_board: Float64


class RigProblem:
    """The corners that cameras with known lenses saw at K instants.

    Args:
        captures: Of every instant, what each camera saw.
        board: The board.
        cameras: The cameras.
    """

    def __init__(
        self, captures: Sequence[Mapping[int, Corners]], board: Board, cameras: Sequence[Known]
    ) -> None:
        self.captures = list(captures)
        self.cameras = list(cameras)
        self._board = board
        self._points_m = board.points_m

    def solve(self, state: RigState) -> RigState:
        """The poses of the least error, from a start near them."""
        cost, damping = self._cost(state), 1e-4
        for _ in range(_ROUNDS):
            normal, gradient = self._normal(state)
            step: Float64 = np.linalg.solve(_damped(normal, damping), -gradient).astype(np.float64)
            trial = self._moved(state, step)
            trial_cost = self._cost(trial)
            if trial_cost < cost:
                gain, state, cost = cost - trial_cost, trial, trial_cost
                damping = max(0.2 * damping, 1e-12)
                if gain < _SETTLED * cost:
                    break
            else:
                damping *= 10.0
                if damping > 1e8:
                    break
        return state

    def rms_px(self, state: RigState) -> float:
        """Distance of found from predicted corners."""
        return _rms([seen.off_px for seen in self._seen(state)])

    def camera_rms_px(self, state: RigState) -> Float64:
        """The same of each camera, shape (C,)."""
        seen = list(self._seen(state))
        every = range(len(self.cameras))
        return np.array([_rms([item.off_px for item in seen if item.camera == camera]) for camera in every])

    def capture_rms_px(self, state: RigState) -> Float64:
        """The same of each instant, shape (K,)."""
        seen = list(self._seen(state))
        every = range(len(self.captures))
        return np.array([_rms([item.off_px for item in seen if item.capture == one]) for one in every])

    def camera_std(self, state: RigState) -> tuple[Float64, Float64]:
        """Largest standard deviations of each camera's turn, rad, and optical centre, m; each shape (C,)."""
        covariance = self._covariance(state)
        turn_std, place_std = [0.0], [0.0]  # the first camera stands where it stands
        for camera in range(1, len(self.cameras)):
            block = slice(6 * camera - 6, 6 * camera)
            by_pose = _centre_slope(state.cameras[camera])
            centre = np.diag(by_pose @ covariance[block, block] @ by_pose.T)
            turn_std.append(_largest_std(np.diag(covariance[block, block])[:3]))
            place_std.append(_largest_std(centre))
        return np.array(turn_std), np.array(place_std)

    def board_std(self, state: RigState) -> tuple[float, float]:
        """Largest standard deviations of the first board's turn, rad, and origin, m."""
        variance = np.diag(self._covariance(state))[6 * (len(self.cameras) - 1) :]
        return _largest_std(variance[:3]), _largest_std(variance[3:6])

    def without(self, capture: int, state: RigState) -> tuple[RigProblem, RigState]:
        """The same less one instant."""
        rest = [item for row, item in enumerate(self.captures) if row != capture]
        return RigProblem(rest, self._board, self.cameras), RigState(
            state.cameras, np.delete(state.boards, capture, axis=0)
        )

    def connected(self) -> bool:
        """Whether every camera is chained to the first."""
        reached = {0}
        while True:
            more = {camera for item in self.captures if reached & set(item) for camera in item}
            if more <= reached:
                return len(reached) == len(self.cameras)
            reached |= more

    def fewest_shared(self) -> int:
        """Instants at which a camera saw the board together with another; of the camera with the fewest."""
        return min(sum(camera in item for item in self.captures) for camera in range(len(self.cameras)))

    def _covariance(self, state: RigState) -> Float64:
        """Covariance of the poses, cameras but the first, then boards, by the residual that is left."""
        normal, _ = self._normal(state)
        values = 2 * sum(len(corners.index) for capture in self.captures for corners in capture.values())
        variance_px2 = 2.0 * self._cost(state) / max(values - len(normal), 1)
        return (variance_px2 * np.linalg.pinv(normal)).astype(np.float64)

    def _cost(self, state: RigState) -> float:
        return 0.5 * sum(float((seen.off_px**2).sum()) for seen in self._seen(state))

    def _normal(self, state: RigState) -> tuple[Float64, Float64]:
        """Normal matrix and gradient over the cameras but the first, then the boards."""
        boards_from = 6 * (len(self.cameras) - 1)
        size = boards_from + 6 * len(self.captures)
        normal, gradient = np.zeros((size, size)), np.zeros(size)
        for seen in self._seen(state):
            board = slice(boards_from + 6 * seen.capture, boards_from + 6 * seen.capture + 6)
            off = seen.off_px.reshape(-1)
            normal[board, board] += seen.by_board.T @ seen.by_board
            gradient[board] += seen.by_board.T @ off
            if seen.camera:
                camera = slice(6 * seen.camera - 6, 6 * seen.camera)
                cross = seen.by_camera.T @ seen.by_board
                normal[camera, camera] += seen.by_camera.T @ seen.by_camera
                normal[camera, board] += cross
                normal[board, camera] += cross.T
                gradient[camera] += seen.by_camera.T @ off
        return normal, gradient

    def _seen(self, state: RigState) -> Iterator[_Seen]:
        for row, capture in enumerate(self.captures):
            for camera, corners in capture.items():
                yield self._one(row, camera, corners, state.boards[row], state.cameras[camera])

    def _one(self, row: int, camera: int, corners: Corners, board: Float64, place: Float64) -> _Seen:
        composed: Any = cv2.composeRT(board[:3], board[3:], place[:3], place[3:])
        turn, shift, *parts = composed
        known = self.cameras[camera]
        pixels: Any
        slopes: Any
        pixels, slopes = cv2.projectPoints(
            self._points_m[corners.index], turn, shift, camera_matrix(known.intrinsics), known.lens.vector
        )
        # d(turn, shift) by (first turn, first shift, second turn, second shift), as the library orders them
        turn_by, shift_by = np.hstack(parts[:4]), np.hstack(parts[4:])
        chained = np.asarray(slopes, dtype=np.float64)[:, :6] @ np.vstack([turn_by, shift_by])
        off = np.asarray(pixels, dtype=np.float64).reshape(-1, 2) - corners.pixel_px
        return _Seen(row, camera, off, chained[:, 6:], chained[:, :6])

    def _moved(self, state: RigState, step: Float64) -> RigState:
        parts = step.reshape(-1, 6)
        count = len(self.cameras) - 1
        cameras = state.cameras.copy()
        cameras[1:] += parts[:count]
        return RigState(cameras, state.boards + parts[count:])


def _damped(normal: Float64, damping: float) -> Float64:
    return normal + np.diag(damping * np.maximum(np.diag(normal), 1e-12))


def _centre_slope(pose: Float64) -> Float64:
    """How the optical centre changes with rotation vector and translation, shape (3, 6)."""
    steps = np.concatenate([np.eye(6), -np.eye(6)]) * 1e-6
    centres = np.array([-matrix_of(one[:3]).T @ one[3:] for one in pose + steps])
    return (centres[:6] - centres[6:]).T / 2e-6


def _largest_std(variance: Float64) -> float:
    return float(np.sqrt(max(float(variance.max()), 0.0)))


def _rms(parts: Sequence[Float64]) -> float:
    return float(np.sqrt((np.concatenate(parts) ** 2).sum(axis=1).mean())) if parts else 0.0
