"""What guided assessments hear, find and keep."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np

from rehab_app.therapy.run import PlayResult
from robot_iface.motion.limits import SweepResult
from robot_iface.runtime import Message
from robot_iface.runtime.sweep_fit_reading import FitResult
from robot_iface.runtime.sweep_tone_reading import ToneResult
from robot_iface.types import Float64, PhaseChange, RunEnd, TickBlock
from sessions.catalogue import DayLimits


@dataclass(frozen=True, slots=True)
class MeasuredLimits:
    """Limits that were measured just now.

    Attributes:
        run: The sealed session of the sweep.
        result: What it measured.
        kept: The limits, which hold until the day ends.
    """

    run: PlayResult
    result: SweepResult
    kept: DayLimits


@dataclass(frozen=True, slots=True)
class CheckedFit:
    """A fit check.

    Attributes:
        run: Its sealed session.
        result: What it found; ``verdict`` is empty where the device fits.
    """

    run: PlayResult
    result: FitResult


@dataclass(frozen=True, slots=True)
class ToneRun:
    """A tone test.

    Attributes:
        run: Its sealed session.
        result: What it found.
    """

    run: PlayResult
    result: ToneResult


class Heard:
    """Everything that a run said and that a measurement is read from."""

    def __init__(self) -> None:
        self.blocks: list[TickBlock] = []
        self.phases: list[PhaseChange] = []
        self._end: RunEnd | None = None

    @property
    def end(self) -> RunEnd:
        """How it ended; a run that is sealed has ended."""
        assert self._end is not None
        return self._end

    def take(self, message: Message | RunEnd) -> None:
        """Keep one message."""
        if isinstance(message, TickBlock):
            self.blocks.append(message)
        elif isinstance(message, PhaseChange):
            self.phases.append(message)
        elif isinstance(message, RunEnd):
            self._end = message


def device_ends(result: SweepResult) -> tuple[str, ...]:
    """Ends of range that are the device's own, as sentences: the patient's is at least that, never that."""
    told: list[str] = []
    for posture, row, angles in zip(result.postures, result.device_end, result.passive_rad, strict=True):
        for joint, at_end, angle, rest in zip(result.joint_names, row, angles, result.rest_rad, strict=True):
            if at_end:
                degrees = f"{math.degrees(angle):.0f} degrees"
                bound = f"at least {degrees}" if angle > rest else f"{degrees} or less"
                told.append(f"{joint} in {posture}: {bound}, device limit.")
    return tuple(told)


def fit_to_json(result: FitResult) -> str:
    """What a fit check found, by joint; what was not measured is left out, JSON has no word for it."""
    columns = {
        "gain": result.gain,
        "stiffness_nm_rad": result.stiffness_nm_rad,
        "sticking_nm": result.sticking_nm,
        "neutral_rad": result.neutral_rad,
    }
    return json.dumps(
        {
            name: {
                key: float(values[joint]) for key, values in columns.items() if math.isfinite(values[joint])
            }
            for joint, name in enumerate(result.joint_names)
        }
    )


def neutral_from_json(text: str, joint_names: tuple[str, ...]) -> Float64:
    """Neutral angles of a kept fit check in the order of the joints, (J,); NaN where there was none."""
    by_joint: dict[str, dict[str, float]] = json.loads(text)
    return np.array([by_joint.get(name, {}).get("neutral_rad", math.nan) for name in joint_names])
