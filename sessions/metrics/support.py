"""With how much help: stiffness by joint, assistance by digit, and both in words beside every error."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.recording import ACTIVE_PHASES, Origin, Phases
from sessions.metrics.robot_fold import Commanded, Folded
from sessions.records import DIGITS
from sessions.records.fields import Float64
from sessions.records.topics import PHASE, ROBOT_COMMAND


def assistance(phases: Phases) -> Float64:
    """Mean stiffness multiple by digit while moving and holding, shape (5,), NaN for digits not driven."""
    rows = np.isin(phases.phase, ACTIVE_PHASES) & (phases.repetition >= 0)
    return mean_assistance(phases.assistance[rows])


def mean_assistance(helped: Float64) -> Float64:
    """Mean by digit, shape (5,), of stiffness multiples (N, 5); NaN for digits not driven."""
    result = np.full(len(DIGITS), np.nan)
    for digit in range(len(DIGITS)):
        values = helped[:, digit]
        known = values[np.isfinite(values)]
        if known.size:
            result[digit] = known.mean()
    return result


def support_metrics(phases: Phases, folded: Folded, origin: Origin) -> list[Metric]:
    """Assistance by digit and stiffness by robot joint.

    Args:
        phases: Phases of the session.
        folded: What the robot's ticks left.
        origin: Which file.
    """
    of_phases = origin.lineage((PHASE,), phases.t_ns)
    span = np.array(folded.stiffness_span_ns if folded.stiffness else (), dtype=np.int64)
    of_commands = origin.lineage((ROBOT_COMMAND, PHASE), span)
    found: list[Metric] = []
    for digit, mean in zip(DIGITS, assistance(phases), strict=True):
        value = (
            Estimate(float(mean)) if np.isfinite(mean) else Estimate.missing("the robot does not drive it")
        )
        found.append(metric("assistance", digit, value, of_phases))
    for joint, one in folded.stiffness.items():
        varies = one.most - one.least > 0.05 * max(1e-9, one.most)
        flag = f"mean; it varied from {one.least:.2f} to {one.most:.2f} Nm/rad" if varies else ""
        found.append(metric("stiffness", joint, Estimate(one.mean), of_commands, flag))
    if not folded.stiffness:
        missing = Estimate.missing("the file holds no robot command")
        found.append(metric("stiffness", "whole", missing, of_commands))
    return found


def conditions(phases: Phases, stiffness: Mapping[str, Commanded]) -> str:
    """The help in words, such as "stiffness 0.90 to 1.20 Nm/rad (3.0 times the thesis gains), passive mode".

    Empty where neither command nor assistance is in the file: then no error may be shown.
    """
    helped = assistance(phases)
    known = helped[np.isfinite(helped)]
    words: list[str] = []
    if stiffness:
        means = [one.mean for one in stiffness.values()]
        words.append(f"stiffness {_span(min(means), max(means), 2)} Nm/rad")
    if known.size:
        multiple = f"{_span(float(known.min()), float(known.max()), 1)} times the thesis gains"
        words = [f"{words[0]} ({multiple})"] if words else [f"stiffness {multiple}"]
    return ", ".join([*words, _modes(phases)]) if words else ""


def modes(phases: Phases) -> tuple[str, ...]:
    """Therapy modes in the order in which they occurred."""
    return tuple(dict.fromkeys(str(mode) for mode in phases.mode if mode))


def _modes(phases: Phases) -> str:
    return f"{' and '.join(modes(phases)) or 'unknown'} mode"


def _span(low: float, high: float, digits: int) -> str:
    first, last = f"{low:.{digits}f}", f"{high:.{digits}f}"
    return first if first == last else f"{first} to {last}"
