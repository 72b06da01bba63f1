"""Patient and therapist side by side: rows with equal time, and the error between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sessions.metrics.hand_motion import ESTIMATED, HandMotion
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.recording import Origin, seconds
from sessions.metrics.strokes import over_strokes
from sessions.metrics.timing import Decomposition, decompose
from sessions.metrics.tracking import pooled_rmse, rmse_columns
from sessions.records import DIGITS, JOINTS
from sessions.records.fields import Float64, Int64
from sessions.records.topics import PATIENT_POSE, PHASE, REFERENCE

UNKNOWN_STIFFNESS = "the stiffness at which it was obtained is not in the file"
TOPICS = (PATIENT_POSE, REFERENCE, PHASE)
MANY = 10_000
"""Rows above which joints are compared a few at a time: copies of all of half an hour would not fit."""
AT_ONCE = 7
DECOMPOSED = 12
"""Most repetitions whose error is taken apart, spread evenly over the session."""
_PARTS: tuple[tuple[str, Callable[[Decomposition], Estimate]], ...] = (
    ("timing_delay", lambda one: one.delay),
    ("timing_warp", lambda one: one.warp),
    ("shape_error", lambda one: one.shape),
    ("offset_error", lambda one: one.offset),
)


@dataclass(frozen=True, slots=True)
class Followed:
    """Rows in which the patient was measured while the therapist's movement was played.

    Attributes:
        patient: The patient's hand at the paired rows, N of them.
        reference_joints_rad: The therapist's angles at the same path coordinate, shape (N, 21).
        reference_tips_m: The therapist's fingertips, shape (N, 5, 3).
        repetition: Repetition that was moved or held, -1 where none, shape (N,).
        joints_rad: The patient's angles, NaN where they may not be used, shape (N, 21).
        joint_flags: What must be said of each joint, 21 of them.
        tips_m: The patient's fingertips, NaN where they may not be used, shape (N, 5, 3).
    """

    patient: HandMotion
    reference_joints_rad: Float64
    reference_tips_m: Float64
    repetition: Int64
    joints_rad: Float64
    joint_flags: tuple[str, ...]
    tips_m: Float64

    def moving(self, repetition: int | None = None) -> Int64:
        """Row numbers of one repetition, or of all."""
        rows = self.repetition >= 0 if repetition is None else self.repetition == repetition
        return np.flatnonzero(rows).astype(np.int64)

    def joint_errors(self, rows: Int64) -> list[tuple[Estimate, bool]]:
        """Error of each of the 21 joints over some row numbers, and whether it was measured."""
        width, errors = AT_ONCE if rows.size > MANY else len(JOINTS), list[Estimate]()
        for first in range(0, len(JOINTS), width):
            some = slice(first, first + width)
            std = self.patient.joint_std_rad[:, some][rows]
            errors += rmse_columns(
                self.joints_rad[:, some][rows], self.reference_joints_rad[:, some][rows], std
            )
        return [(error, flag != ESTIMATED) for error, flag in zip(errors, self.joint_flags, strict=True)]

    def fingertip_errors(self, rows: Int64) -> list[Estimate]:
        """Error of each of the five fingertips over some row numbers."""
        return rmse_columns(
            self.tips_m[rows], self.reference_tips_m[rows], self.patient.fingertip_std_m[rows]
        )

    def joint_rmse(self, rows: Int64) -> Estimate:
        """Joint error over all measured joints."""
        return pooled_rmse([error for error, measured in self.joint_errors(rows) if measured])

    def fingertip_rmse(self, rows: Int64) -> Estimate:
        """Fingertip error over all digits."""
        return pooled_rmse(self.fingertip_errors(rows))


def pair(
    patient: HandMotion, t_reference_ns: Int64, joints_rad: Float64, tips_m: Float64
) -> tuple[Int64, Int64]:
    """Rows of patient and reference with equal time.

    Args:
        patient: The patient's hand.
        t_reference_ns: Times of the reference, shape (M,).
        joints_rad: Its angles, shape (M, 21).
        tips_m: Its fingertips, shape (M, 5, 3).

    Returns:
        Row numbers in the patient's and in the reference's columns, both of the same length.
    """
    known = np.atleast_1d(np.isfinite(joints_rad).all(axis=1) & np.isfinite(tips_m).all(axis=(1, 2)))
    _, of_patient, of_reference = np.intersect1d(patient.t_ns, t_reference_ns, return_indices=True)
    kept = known[of_reference]
    return of_patient[kept].astype(np.int64), of_reference[kept].astype(np.int64)


def followed_by(patient: HandMotion, joints_rad: Float64, tips_m: Float64, repetition: Int64) -> Followed:
    """Put paired rows side by side, sorting out once what may be used.

    Args:
        patient: The patient's hand at the paired rows, N of them.
        joints_rad: The therapist's angles, shape (N, 21).
        tips_m: The therapist's fingertips, shape (N, 5, 3).
        repetition: Repetition that was moved or held, -1 where none, shape (N,).
    """
    angles, flags = patient.usable_joints()
    return Followed(patient, joints_rad, tips_m, repetition, angles, flags, patient.usable_tips())


def tracking_metrics(followed: Followed, origin: Origin, conditions: str) -> list[Metric]:
    """Error by joint, by digit and over all; never without the stiffness it was obtained at.

    Args:
        followed: The paired rows.
        origin: Which file.
        conditions: The stiffness in words; empty where it is unknown: then no error is given.
    """
    rows = followed.moving()
    lineage = origin.lineage(TOPICS, followed.patient.t_ns[rows], conditions)
    hidden = Estimate.missing(UNKNOWN_STIFFNESS)
    found: list[Metric] = []
    joints, tips = followed.joint_errors(rows), followed.fingertip_errors(rows)
    for column, (joint, (error, measured)) in enumerate(zip(JOINTS, joints, strict=True)):
        flag = followed.joint_flags[column] if measured else ESTIMATED
        found.append(metric("joint_rmse", joint, error if conditions else hidden, lineage, flag))
    for column, (digit, error) in enumerate(zip(DIGITS, tips, strict=True)):
        flag = followed.patient.tip_flag(column)
        found.append(metric("fingertip_rmse", digit, error if conditions else hidden, lineage, flag))
    over_joints = pooled_rmse([error for error, measured in joints if measured])
    whole = (("joint_rmse", over_joints), ("fingertip_rmse", pooled_rmse(tips)))
    found += [metric(name, "whole", error if conditions else hidden, lineage) for name, error in whole]
    return found


def decomposed_metrics(followed: Followed, origin: Origin, conditions: str) -> list[Metric]:
    """Timing, shape and offset of each fingertip's error; the mean over repetitions with its t-interval.

    Args:
        followed: The paired rows.
        origin: Which file.
        conditions: The stiffness in words; empty where it is unknown: then nothing is given.
    """
    made = np.unique(followed.repetition[followed.repetition >= 0])
    chosen = made[np.unique(np.linspace(0, made.size - 1, min(made.size, DECOMPOSED)).astype(np.int64))]
    lineage = origin.lineage(TOPICS, followed.patient.t_ns[followed.moving()], conditions)
    found: list[Metric] = []
    for column, digit in enumerate(DIGITS):
        parts = [_decomposed(followed, column, int(index)) for index in chosen] if conditions else []
        flag = followed.patient.tip_flag(column)
        for name, read in _PARTS:
            estimate = over_strokes([read(part) for part in parts])
            if not parts:
                estimate = Estimate.missing("no repetition" if conditions else UNKNOWN_STIFFNESS)
            found.append(metric(name, digit, estimate, lineage, flag))
    return found


def _decomposed(followed: Followed, digit: int, repetition: int) -> Decomposition:
    rows = followed.moving(repetition)
    t_s = seconds(followed.patient.t_ns[rows])
    return decompose(t_s, followed.tips_m[rows, digit], followed.reference_tips_m[rows, digit])
