"""The newest telemetry of a run as the live page draws it."""

from __future__ import annotations

import numpy as np

from rehab_app.services.live_board import Board
from rehab_app.services.replay import COMPARED_PHASES
from rehab_app.services.rows import PreparedPlan
from rehab_app.therapy.run_poses import run_hand
from robot_iface.build import capabilities
from robot_iface.link import LiveSample
from robot_iface.types import Float64


class RunPicture:
    """Turns samples into pictures on the board; a run without a path has no therapist in it.

    Args:
        board: Where the picture is shown.
        prepared: What is run.
    """

    def __init__(self, board: Board, prepared: PreparedPlan) -> None:
        self._board = board
        self._hand = run_hand(capabilities(prepared.plan.device), prepared.geometry)
        self._follows = prepared.plan.path is not None
        self._last_ns = -1

    def draw(self, sample: LiveSample) -> None:
        """Publish what the motion process measured since the last picture."""
        if sample.t_ns == self._last_ns or not sample.q_rad.size:
            return
        self._last_ns = sample.t_ns
        patient = self._hand.poses(sample.q_rad[None])
        therapist: Float64 | None = None
        error_m: Float64 | None = None
        if self._follows:
            reference = self._hand.poses(sample.q_reference_rad[None])
            therapist = reference.joints_rad[0]
            if sample.phase in COMPARED_PHASES:
                apart_m = np.linalg.norm(patient.fingertips_m[0] - reference.fingertips_m[0], axis=1)
                error_m = np.asarray(apart_m, dtype=np.float64)
                self._board.add_error(sample.t_ns / 1e9, float(np.sqrt(np.mean(np.square(error_m)))))
        self._board.picture(
            t_s=sample.t_ns / 1e9,
            therapist_joints_rad=therapist,
            patient_joints_rad=patient.joints_rad[0],
            fingertip_error_m=error_m,
            phase=sample.phase,
            repetition=sample.repetition,
            started_by=sample.started_by,
            support=float(np.mean(sample.stiffness_multiple)),
            interaction_nm=float(np.max(np.abs(sample.tau_interaction_nm))),
            safety_state=sample.safety_state.name,
            late_p99_ns=sample.late_p99_ns,
            overruns=sample.overruns,
        )
