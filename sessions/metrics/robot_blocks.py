"""What the robot's blocks say: stiffness, interaction and work, by joint, digit and repetition."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.effort import MOVED_RAD, NOT_SEPARABLE, Work, robot_share, work
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.recording import Origin, Phases, Recording, seconds
from sessions.records import DIGITS, digit_of
from sessions.records.fields import Float64, Int64
from sessions.records.topics import PHASE, ROBOT_COMMAND, ROBOT_STATE

NO_ROBOT = "the file holds no robot state"


@dataclass(frozen=True, slots=True)
class RepetitionTicks:
    """One repetition as the robot felt it, J joints.

    Attributes:
        works: Work at each joint.
        moved_rad: Largest less smallest position, shape (J,).
        square_nm2: Mean square of the interaction torque, NaN where it was not measured, shape (J,).
        peak_nm: Largest absolute interaction torque, NaN where it was not measured, shape (J,).
    """

    works: tuple[Work, ...]
    moved_rad: Float64
    square_nm2: Float64
    peak_nm: Float64


@dataclass(frozen=True, slots=True)
class RobotTicks:
    """What the robot measured within repetitions.

    Attributes:
        joints: Names of the J columns.
        t_ns: Times of the ticks within repetitions, shape (N,).
        repetitions: What it felt, by repetition index.
    """

    joints: tuple[str, ...]
    t_ns: Int64
    repetitions: Mapping[int, RepetitionTicks]

    def share(self, columns: list[int], repetition: int | None = None) -> Estimate:
        """Robot's share over some joints, in one repetition or in all."""
        found = [
            item for index, item in self.repetitions.items() if repetition is None or index == repetition
        ]
        if not found:
            return Estimate.missing(NO_ROBOT)
        moved = np.max([item.moved_rad for item in found], axis=0)
        chosen = [column for column in columns if moved[column] >= MOVED_RAD]
        if not chosen:
            return robot_share([], 0.0, 0.0)
        square = float(np.mean([item.square_nm2[chosen] for item in found]))
        if not np.isfinite(square):
            return Estimate.missing("the device does not measure interaction torque")
        works = [item.works[column] for item in found for column in chosen]
        return robot_share(works, float(np.sqrt(square)), float(moved.max()))

    def of_digit(self, digit: str) -> list[int]:
        """Columns that belong to a digit."""
        return [column for column, joint in enumerate(self.joints) if digit_of(joint) == digit]


def read_robot(recording: Recording, phases: Phases) -> RobotTicks:
    """The robot's state; without joints where the file has none."""
    joints = recording.header.robot_joints
    if not joints or not recording.counts.get(ROBOT_STATE.name, 0):
        return RobotTicks((), np.empty(0, dtype=np.int64), {})
    rows = recording.columns(ROBOT_STATE)
    t_ns: Int64 = np.asarray(rows["t_ns"], dtype=np.int64)
    shape = (len(t_ns), len(joints))
    q, dq, tau = (
        np.asarray(rows[name], dtype=np.float64).reshape(shape)
        for name in ("q_rad", "dq_rad_s", "tau_interaction_nm")
    )
    repetition = phases.active_repetition(t_ns)
    rows = np.flatnonzero(repetition >= 0)
    rows = rows[np.argsort(repetition[rows], kind="stable")]
    numbers, starts = np.unique(repetition[rows], return_index=True)
    ends = [*starts[1:], rows.size]
    felt = {
        int(number): _felt(t_ns[part], q[part], dq[part], tau[part])
        for number, start, end in zip(numbers, starts, ends, strict=True)
        for part in (rows[start:end],)
    }
    return RobotTicks(joints, t_ns[rows], felt)


def _felt(t_ns: Int64, q: Float64, dq: Float64, tau: Float64) -> RepetitionTicks:
    """Take together one repetition: positions, speeds and torques of shape (N, J)."""
    t_s = seconds(t_ns)
    known = np.isfinite(tau)
    count = np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    magnitude = np.where(known, np.abs(tau), 0.0)
    return RepetitionTicks(
        tuple(work(t_s, tau[:, column], dq[:, column]) for column in range(tau.shape[1])),
        np.ptp(q, axis=0),
        (magnitude**2).sum(axis=0) / count,
        np.where(known.any(axis=0), magnitude.max(axis=0), np.nan),
    )


def effort_metrics(robot: RobotTicks, origin: Origin) -> list[Metric]:
    """Robot's share by digit and over all, its work, and the largest interaction torque by joint."""
    lineage = origin.lineage((ROBOT_STATE, PHASE), robot.t_ns)
    every = list(range(len(robot.joints)))
    found = [metric("robot_share", "whole", robot.share(every), lineage)]
    found += [metric("robot_share", digit, robot.share(robot.of_digit(digit)), lineage) for digit in DIGITS]
    if not robot.repetitions:
        missing = Estimate.missing(NO_ROBOT)
        return [
            *found,
            *(metric(name, "whole", missing, lineage) for name in ("robot_work", "returned_work")),
        ]
    works = [item for felt in robot.repetitions.values() for item in felt.works]
    found.append(metric("robot_work", "whole", Estimate(sum(item.robot_j for item in works)), lineage))
    returned = Estimate(sum(item.returned_j for item in works))
    found.append(metric("returned_work", "whole", returned, lineage, NOT_SEPARABLE))
    for column, joint in enumerate(robot.joints):
        largest = [float(felt.peak_nm[column]) for felt in robot.repetitions.values()]
        known = [value for value in largest if value == value]
        peak = Estimate(max(known)) if known else Estimate.missing("no interaction torque was measured")
        found.append(metric("interaction_torque", joint, peak, lineage))
    return found


def read_stiffness(recording: Recording, phases: Phases) -> tuple[Int64, dict[str, Float64]]:
    """Requested stiffness while the patient was compared with the therapist.

    Returns:
        Times of the ticks (N,) and the stiffness by robot joint, Nm/rad (N,); empty where the file has none.
    """
    joints = recording.header.robot_joints
    if not joints or not recording.counts.get(ROBOT_COMMAND.name, 0):
        return np.empty(0, dtype=np.int64), {}
    rows = recording.columns(ROBOT_COMMAND)
    t_ns: Int64 = np.asarray(rows["t_ns"], dtype=np.int64)
    stiffness = np.asarray(rows["stiffness_nm_rad"], dtype=np.float64).reshape(len(t_ns), len(joints))
    active: NDArray[np.bool_] = phases.active_repetition(t_ns) >= 0
    if not bool(active.any()):
        return np.empty(0, dtype=np.int64), {}
    return t_ns[active], {joint: stiffness[active, column] for column, joint in enumerate(joints)}
