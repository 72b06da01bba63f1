"""A first guess of where cameras stand: pairs that see the board together, chained to the first camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.board_pose import BoardPose, board_pose, matrix_of, vector_of
from rehab_app.calibration.corners import Corners
from rehab_app.calibration.rig_problem import Known, RigState
from rehab_app.errors import Refused
from sessions.records.fields import Float64

Capture = Mapping[int, Corners]
_NEAR_RAD = 0.15
_NEAR_SHARE = 0.15  # of the board's distance


@dataclass(frozen=True, slots=True)
class RigStart:
    """Where the solution begins.

    Attributes:
        captures: The instants that agree on where the cameras stand.
        left_out: The others.
        state: Poses of cameras and boards.
    """

    captures: list[Capture]
    left_out: list[Capture]
    state: RigState


@dataclass(frozen=True, slots=True)
class _Guess:
    """``T_second_first`` of two cameras by one instant."""

    capture: int
    half_turned: bool
    rotation: Float64
    p_m: Float64
    distance_m: float

    def near(self, other: _Guess) -> bool:
        """Whether two instants say about the same."""
        between = 0.5 * (np.trace(self.rotation.T @ other.rotation) - 1.0)
        away_m = float(np.linalg.norm(self.p_m - other.p_m))
        return float(np.arccos(np.clip(between, -1, 1))) < _NEAR_RAD and away_m < _NEAR_SHARE * max(
            self.distance_m, other.distance_m
        )


def rig_start(captures: Sequence[Capture], board: Board, cameras: Sequence[Known]) -> RigStart:
    """Poses near the solution, from the instants that agree with most others.

    A board that looks the same after half a turn may be counted from either end in each image: the way
    round on which the instants agree is the true one.

    Raises:
        Refused: A camera shares no instant with those that are chained to the first.
    """
    poses = [_poses(capture, board, cameras) for capture in captures]
    turned = list(captures)
    agreeing = [bool(pose) for pose in poses]
    place: dict[int, tuple[Float64, Float64]] = {0: (np.eye(3), np.zeros(3))}
    while len(place) < len(cameras):
        first, second = _next_pair(poses, set(place), len(cameras))
        guesses = [
            guess for row in range(len(poses)) for guess in _guesses(row, poses[row], first, second, board)
        ]
        best = max(guesses, key=lambda one: sum(one.near(other) for other in guesses))
        said = {guess.capture for guess in guesses}
        near = {guess.capture: guess for guess in guesses if guess.near(best)}
        for row in said:
            agreeing[row] &= row in near
            if row in near and near[row].half_turned:
                turned[row] = {**turned[row], second: _half_turned(turned[row][second])}
                poses[row] = _poses(turned[row], board, cameras)
        rotation, p_m = place[first]
        place[second] = best.rotation @ rotation, best.rotation @ p_m + best.p_m
    kept = [row for row, good in enumerate(agreeing) if good]
    boards = [_board_row(turned[row], board, cameras, place) for row in kept]
    state = RigState(np.array([_row(*place[number]) for number in range(len(cameras))]), np.array(boards))
    left_out = [captures[row] for row, good in enumerate(agreeing) if not good]
    return RigStart([turned[row] for row in kept], left_out, state)


def _poses(capture: Capture, board: Board, cameras: Sequence[Known]) -> dict[int, BoardPose]:
    found = {
        number: board_pose(corners, board, cameras[number].intrinsics, cameras[number].lens)
        for number, corners in capture.items()
    }
    return {number: pose for number, pose in found.items() if pose is not None}


def _next_pair(poses: Sequence[Mapping[int, BoardPose]], placed: set[int], count: int) -> tuple[int, int]:
    """The camera outside that shares most instants with one inside."""
    pairs = {
        (first, second): sum(first in pose and second in pose for pose in poses)
        for first in sorted(placed)
        for second in range(count)
        if second not in placed
    }
    best = max(pairs, key=lambda pair: pairs[pair])
    if not pairs[best]:
        missing = ", ".join(str(number + 1) for number in range(count) if number not in placed)
        raise Refused(
            f"board in the images of camera {missing}",
            "never seen together with another camera",
            "seen by two cameras at the same instant",
            "show the board where the views of the cameras overlap",
        )
    return best


def _guesses(row: int, poses: Mapping[int, BoardPose], first: int, second: int, board: Board) -> list[_Guess]:
    if first not in poses or second not in poses:
        return []
    one, other = poses[first], poses[second]
    guesses = [_guess(row, False, one, matrix_of(other.turn_rad), other)]
    if not board.one_way_up:
        rotation = matrix_of(other.turn_rad)
        middle = 0.5 * board.points_m[-1]
        # half a turn about the board's middle: x and y change sign, the far corner becomes the first
        swapped = replace(other, p_camera_board_m=other.p_camera_board_m + rotation @ (2 * middle))
        guesses.append(_guess(row, True, one, rotation @ np.diag([-1.0, -1.0, 1.0]), swapped))
    return guesses


def _guess(row: int, half_turned: bool, one: BoardPose, rotation: Float64, other: BoardPose) -> _Guess:
    between = rotation @ matrix_of(one.turn_rad).T
    p_m = other.p_camera_board_m - between @ one.p_camera_board_m
    return _Guess(row, half_turned, between, p_m, float(np.linalg.norm(other.p_camera_board_m)))


def _half_turned(corners: Corners) -> Corners:
    """The same corners counted from the other end (of a chessboard, all of which is seen)."""
    return replace(corners, pixel_px=corners.pixel_px[::-1])


def _board_row(
    capture: Capture, board: Board, cameras: Sequence[Known], place: Mapping[int, tuple[Float64, Float64]]
) -> Float64:
    """``T_tracking_board`` by the camera that sees the board best."""
    poses = _poses(capture, board, cameras)
    number = min(poses, key=lambda camera: poses[camera].rms_px)
    rotation, p_m = place[number]
    inside = rotation.T @ matrix_of(poses[number].turn_rad)
    return _row(inside, rotation.T @ (poses[number].p_camera_board_m - p_m))


def _row(rotation: Float64, p_m: Float64) -> Float64:
    return np.concatenate([vector_of(rotation), p_m])
