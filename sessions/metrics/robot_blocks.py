"""What the robot's blocks say: interaction and work, by joint, digit and repetition."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sessions.metrics.effort import MOVED_RAD, NOT_SEPARABLE, robot_share
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.recording import Origin
from sessions.metrics.robot_stretch import Stretch
from sessions.metrics.separated import Separation
from sessions.records import DIGITS, digit_of
from sessions.records.fields import Float64, Int64
from sessions.records.topics import PHASE, ROBOT_STATE

NO_ROBOT = "the file holds no robot state"
UNMEASURED = "the device does not measure interaction torque"


@dataclass(frozen=True, slots=True)
class RobotTicks:
    """What the robot measured within repetitions.

    Attributes:
        joints: Names of the J joints; empty where the file has no robot state.
        stretches: What it felt, in the order of the file.
        separation: What is known of the patient's own part in it.
    """

    joints: tuple[str, ...]
    stretches: tuple[Stretch, ...]
    separation: Separation

    @property
    def t_ns(self) -> Int64:
        """Times of the first and last tick within repetitions, shape (2,), or (0,) without one."""
        if not self.stretches:
            return np.empty(0, dtype=np.int64)
        ends = [end for one in self.stretches for end in one.span_ns]
        return np.array([min(ends), max(ends)], dtype=np.int64)

    def share(self, columns: list[int], repetition: int | None = None) -> Estimate:
        """Robot's share over some joints, in one repetition or in all.

        Nothing can be told from the interaction alone: recoil of stiff tissue and friction come back like
        effort. So there is a value only where the robot applied no torque, or recoil was taken off.
        """
        found = [one for one in self.stretches if repetition is None or one.repetition == repetition]
        if not found:
            return Estimate.missing(NO_ROBOT)
        moved = np.max([one.high_rad for one in found], axis=0) - np.min(
            [one.low_rad for one in found], axis=0
        )
        chosen = [column for column in columns if moved[column] >= MOVED_RAD]
        if not chosen:
            return robot_share([], 0.0, 0.0)
        mean = _mean_square(found)[chosen]
        if not np.isfinite(mean).all():
            return Estimate.missing(UNMEASURED)
        works = [one.works[column] for one in found for column in chosen]
        share = robot_share(works, math.sqrt(float(mean.mean())), float(moved.max()))
        return self.separation.share(chosen, repetition) if share.reason == NOT_SEPARABLE else share

    def of_digit(self, digit: str) -> list[int]:
        """Columns that belong to a digit."""
        return [column for column, joint in enumerate(self.joints) if digit_of(joint) == digit]


def _mean_square(found: list[Stretch]) -> Float64:
    """Mean square of the torque over all ticks that measured it, shape (J,); NaN where none did."""
    square = np.sum([one.square_nm2 for one in found], axis=0)
    known = np.sum([one.known for one in found], axis=0)
    return np.where(known > 0, square / np.maximum(known, 1), math.nan)


def effort_metrics(robot: RobotTicks, origin: Origin) -> list[Metric]:
    """Robot's share by digit and over all, its work, and the largest interaction torque by joint."""
    lineage = origin.lineage((ROBOT_STATE, PHASE), robot.t_ns)
    by_share = origin.lineage((ROBOT_STATE, PHASE), robot.t_ns, robot.separation.conditions)
    every = list(range(len(robot.joints)))
    found = [metric("robot_share", "whole", robot.share(every), by_share)]
    found += [metric("robot_share", digit, robot.share(robot.of_digit(digit)), by_share) for digit in DIGITS]
    if not robot.stretches:
        missing = Estimate.missing(NO_ROBOT)
        return [
            *found,
            *(metric(name, "whole", missing, lineage) for name in ("robot_work", "returned_work")),
        ]
    if not np.isfinite(_mean_square(list(robot.stretches))).any():
        missing = Estimate.missing(UNMEASURED)
        found += [metric(name, "whole", missing, lineage) for name in ("robot_work", "returned_work")]
    else:
        works = [item for one in robot.stretches for item in one.works]
        given, returned = (
            Estimate(math.fsum(getattr(item, name) for item in works)) for name in ("robot_j", "returned_j")
        )
        found.append(metric("robot_work", "whole", given, lineage))
        found.append(metric("returned_work", "whole", returned, lineage, NOT_SEPARABLE))
    for column, joint in enumerate(robot.joints):
        known = [float(one.peak_nm[column]) for one in robot.stretches if math.isfinite(one.peak_nm[column])]
        peak = Estimate(max(known)) if known else Estimate.missing("no interaction torque was measured")
        found.append(metric("interaction_torque", joint, peak, lineage))
    return found
