"""Several cameras that see one board at once: where each stands beside the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.board_pose import matrix_of
from rehab_app.calibration.corners import Corners, Rejected
from rehab_app.calibration.rig_problem import Known, RigProblem, RigState
from rehab_app.calibration.rig_start import rig_start
from rehab_app.calibration.verdict import RIG_BOUNDS, Verdict, judge
from rehab_app.errors import Refused
from rehab_app.geometry.view import View
from sessions.records.fields import Float64

_OUTLIER_FACTOR = 3.0
_OUTLIER_PX = 1.0  # at 640 px width


@dataclass(frozen=True, slots=True)
class RigFit:
    """Cameras beside each other, and how well that is known.

    Attributes:
        views: Pose of every camera in the frame of the first, in their order.
        turn_std_rad: Standard deviation of each one's rotation, the largest of three axes, shape (C,).
        place_std_m: Standard deviation of each one's optical centre, the largest of three axes, shape (C,).
        rms_px: Distance of found from predicted corners over all cameras and images.
        camera_rms_px: The same of each camera, shape (C,).
        used: Images used, by their name in the first camera that saw the board.
        rejected: The others, with reasons.
        verdict: What it is worth.
    """

    views: tuple[View, ...]
    turn_std_rad: Float64
    place_std_m: Float64
    rms_px: float
    camera_rms_px: Float64
    used: tuple[str, ...]
    rejected: tuple[Rejected, ...]
    verdict: Verdict

    def baseline_m(self, camera: int = 1) -> float:
        """Distance of a camera's optical centre from the first one's."""
        return float(np.linalg.norm(self.views[camera].p_tracking_camera_m))


def calibrate_rig(
    captures: Sequence[Mapping[int, Corners]], board: Board, cameras: Sequence[Known]
) -> RigFit:
    """Find every camera's place from images of one board that several of them took at the same instant.

    Cameras that never see the board together are chained through those that do. Lenses stay as they are.

    Args:
        captures: Of every instant, what each camera (by its number) saw; at least two cameras saw the board.
        board: The board.
        cameras: The calibrated cameras; the first is the tracking camera.

    Raises:
        Refused: Fewer than two cameras, no instant that two of them share, or a camera that shares none.
    """
    if len(cameras) < 2:
        raise Refused("number of cameras", str(len(cameras)), "2 or more", "give the images of each camera")
    shared = [capture for capture in captures if len(capture) >= 2]
    alone = [_named(capture, "was seen by one camera only") for capture in captures if len(capture) == 1]
    start = rig_start(shared, board, cameras)
    problem = RigProblem(start.captures, board, cameras)
    state = problem.solve(start.state)
    rejected = [*alone, *(_named(capture, "contradicts the other images") for capture in start.left_out)]
    return _without_outliers(problem, state, rejected)


def _without_outliers(problem: RigProblem, state: RigState, rejected: list[Rejected]) -> RigFit:
    """Drop the worst instant while it is unlike the others, and solve again."""
    scale = max(1.0, problem.cameras[0].intrinsics.width_px / 640)
    while len(problem.captures) > 3:
        errors_px = problem.capture_rms_px(state)
        worst = int(np.argmax(errors_px))
        if errors_px[worst] <= max(_OUTLIER_FACTOR * float(np.median(errors_px)), _OUTLIER_PX * scale):
            break
        smaller, start = problem.without(worst, state)
        if not smaller.connected():
            break
        reason = f"does not fit the others (corners {errors_px[worst]:.2f} px off)"
        rejected.append(_named(problem.captures[worst], reason))
        problem, state = smaller, smaller.solve(start)
    return _told(problem, state, rejected)


def _told(problem: RigProblem, state: RigState, rejected: list[Rejected]) -> RigFit:
    turn_std_rad, place_std_m = problem.camera_std(state)
    rms_px = problem.rms_px(state)
    figures = {
        "rms_share": rms_px / max(1.0, problem.cameras[0].intrinsics.width_px / 640),
        "turn_std_rad": float(turn_std_rad.max()),
        "views": float(problem.fewest_shared()),
    }
    return RigFit(
        tuple(_view(number, state) for number in range(len(problem.cameras))),
        turn_std_rad,
        place_std_m,
        rms_px,
        problem.camera_rms_px(state),
        tuple(_named(capture, "").source for capture in problem.captures),
        tuple(rejected),
        judge(figures, RIG_BOUNDS),
    )


def _view(number: int, state: RigState) -> View:
    """``T_tracking_camera`` from the solved ``T_camera_tracking``."""
    rotation = matrix_of(state.cameras[number, :3]).T
    return View(number, rotation, -rotation @ state.cameras[number, 3:])


def _named(capture: Mapping[int, Corners], reason: str) -> Rejected:
    return Rejected(capture[min(capture)].source, reason)
