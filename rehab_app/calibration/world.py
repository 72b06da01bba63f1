"""The world frame of a clinic's table: where a camera stands above a board that lies still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.board_pose import BoardPose, board_pose, matrix_of
from rehab_app.calibration.camera import CalibratedCamera, Placement, check_size
from rehab_app.calibration.corners import Corners, Rejected
from rehab_app.calibration.rig_problem import RigProblem, RigState
from rehab_app.calibration.verdict import WORLD_BOUNDS, Verdict, judge
from rehab_app.errors import Refused
from sessions.records.fields import Float64

_MOVED_SHARE = 0.01  # of the board's distance: more, and the board or the camera was moved
_BOARD_WORLD = np.diag([1.0, -1.0, -1.0])  # half a turn about x: the board's z goes in, the world's comes out


@dataclass(frozen=True, slots=True)
class WorldFit:
    """A camera's place in the world.

    Attributes:
        placement: ``T_world_camera``. The world's origin is the first inner corner of the board, x runs
            along its columns, z comes out of the board towards the camera.
        turn_std_rad: Standard deviation of the rotation, the largest of three axes.
        place_std_m: Standard deviation of the place, the largest of three axes.
        used: Images used.
        rejected: The others, with reasons.
        verdict: What it is worth.
    """

    placement: Placement
    turn_std_rad: float
    place_std_m: float
    used: tuple[str, ...]
    rejected: tuple[Rejected, ...]
    verdict: Verdict


def world_from_board(seen: Sequence[Corners | Rejected], board: Board, camera: CalibratedCamera) -> WorldFit:
    """Find where the camera stands above a board that does not move.

    Args:
        seen: What ``find_board`` said of one or more images of the resting board.
        board: A board that looks different after half a turn.
        camera: The calibrated camera that took them.

    Raises:
        Refused: The board has no first corner, no image shows it, it moved, or the resolution does not fit.
    """
    if not board.one_way_up:
        raise Refused(
            "board for the world frame",
            f"{board.columns} x {board.rows}, the same after half a turn",
            "one whose first corner can be told",
            "use a board with an odd and an even number of inner corners, such as 9x6, or a charuco board",
        )
    found = [item for item in seen if isinstance(item, Corners)]
    rejected = tuple(item for item in seen if isinstance(item, Rejected))
    for item in found:
        check_size(camera, *item.size_px, item.source)
    poses = [board_pose(item, board, camera.intrinsics, camera.lens) for item in found]
    known = [(item, pose) for item, pose in zip(found, poses, strict=True) if pose is not None]
    if not known:
        reason = f" ({rejected[0].source} {rejected[0].reason})" if rejected else ""
        raise Refused("board", f"in none of the images{reason}", "seen", "show all of it, in focus and lit")
    start = _resting([pose for _, pose in known])
    return _solved([item for item, _ in known], start, rejected, board, camera)


def _resting(poses: Sequence[BoardPose]) -> Float64:
    """The pose in the middle of all, rotation vector and translation, shape (6,).

    Raises:
        Refused: They differ by more than noise.
    """
    places_m = np.array([pose.p_camera_board_m for pose in poses])
    middle_m = np.median(places_m, axis=0)
    away_m = np.linalg.norm(places_m - middle_m, axis=1)
    if away_m.max() > _MOVED_SHARE * float(np.linalg.norm(middle_m)):
        raise Refused(
            "board in the images",
            f"moving by {1e3 * away_m.max():.0f} mm",
            "at rest",
            "let board and camera rest and take the images again",
        )
    nearest = poses[int(np.argmin(away_m))]
    return np.concatenate([nearest.turn_rad, nearest.p_camera_board_m])


def _solved(
    found: list[Corners],
    start: Float64,
    rejected: tuple[Rejected, ...],
    board: Board,
    camera: CalibratedCamera,
) -> WorldFit:
    """One pose of the board for all images: the images count as cameras at one place at one instant."""
    joined = replace(
        found[0],
        index=np.concatenate([item.index for item in found]),
        pixel_px=np.concatenate([item.pixel_px for item in found]),
    )
    problem = RigProblem([{0: joined}], board, [camera.known])
    state = problem.solve(RigState(np.zeros((1, 6)), start[None]))
    turn_std_rad, place_std_m = problem.board_std(state)
    rms_px = problem.rms_px(state)
    rotation_camera_world = matrix_of(state.boards[0, :3]) @ _BOARD_WORLD
    rotation = rotation_camera_world.T
    placement = Placement("world", rotation, -rotation @ state.boards[0, 3:], rms_px)
    figures = {
        "rms_share": rms_px / max(1.0, camera.intrinsics.width_px / 640),
        "turn_std_rad": turn_std_rad,
    }
    return WorldFit(
        placement,
        turn_std_rad,
        place_std_m,
        tuple(item.source for item in found),
        rejected,
        judge(figures, WORLD_BOUNDS),
    )
