"""How a repetition began and what helped it: latency of the patient's start, assistance by direction."""

from __future__ import annotations

import numpy as np

from sessions.metrics.followed import Followed
from sessions.metrics.hand_motion import FLEXION
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.recording import Origin, Phases
from sessions.metrics.strokes import over_strokes
from sessions.records import DIGITS, JOINTS, digit_of
from sessions.records.fields import Float64
from sessions.records.topics import PHASE, REFERENCE

DIRECTIONS = (("assistance_opening", -1.0), ("assistance_closing", 1.0))
SLOW_RAD_S = 0.03
"""A reference that turns slower than this neither opens nor closes the digit."""


def latencies(phases: Phases) -> list[Estimate]:
    """Seconds from the cue to the movement, of every repetition that the patient began."""
    found: list[Estimate] = []
    for index in np.unique(phases.repetition[phases.repetition >= 0]):
        rows = np.flatnonzero(phases.repetition == index)
        cued, moved = (rows[phases.phase[rows] == name] for name in ("cue", "move"))
        begun = moved[moved > cued[0]] if cued.size else moved[:0]
        if begun.size and str(phases.started_by[begun[0]]) == "patient":
            found.append(Estimate(float(phases.t_ns[begun[0]] - phases.t_ns[cued[0]]) * 1e-9))
    return found


def helped_along(phases: Phases, followed: Followed, digit: str, direction: float) -> Estimate:
    """Mean stiffness multiple of a digit while the therapist's movement opens or closes it.

    Args:
        phases: Phases of the session.
        followed: The paired rows.
        digit: Which digit.
        direction: 1 closing, -1 opening.
    """
    chosen = [column for column, joint in enumerate(JOINTS) if digit_of(joint) == digit and FLEXION[column]]
    t_s = followed.patient.t_ns * 1e-9
    if t_s.size < 2:
        return Estimate.missing("no sample was measured while the reference was played")
    bend: Float64 = followed.reference_joints_rad[:, chosen].sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        speed: Float64 = np.gradient(bend, t_s)
    rows = (followed.repetition >= 0) & (direction * speed > SLOW_RAD_S)
    at = phases.rows_at(followed.patient.t_ns[rows])
    helped = phases.assistance[at[at >= 0], DIGITS.index(digit)]
    known = helped[np.isfinite(helped)]
    if not known.size:
        words = "closes" if direction > 0 else "opens"
        return Estimate.missing(f"the robot does not drive it while the movement {words} it")
    return Estimate(float(known.mean()))


def start_metrics(phases: Phases, followed: Followed, origin: Origin) -> list[Metric]:
    """Latency of the patient's own starts, and assistance by digit and direction."""
    lineage = origin.lineage((PHASE,), phases.t_ns)
    begun = latencies(phases)
    latency = over_strokes(begun) if begun else Estimate.missing("no repetition was begun by the patient")
    found = [metric("trigger_latency", "whole", latency, lineage)]
    both = origin.lineage((PHASE, REFERENCE), followed.patient.t_ns)
    for name, direction in DIRECTIONS:
        for digit in DIGITS:
            found.append(metric(name, digit, helped_along(phases, followed, digit, direction), both))
    return found
