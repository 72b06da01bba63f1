"""What a guided sweep measured, read from the messages of its run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from robot_iface.motion.limits import SweepResult
from robot_iface.runtime.sweep_task import STOP_SHARE
from robot_iface.types import (
    Capabilities,
    Float64,
    Int64,
    Limits,
    PhaseChange,
    SafetyState,
    Sweep,
    TickBlock,
)

DEVICE_END_RAD = float(np.deg2rad(1.0))
WINDOW_NS = 300_000_000
"""An end of range is the mean over this last part of it."""
QUIET_NS = 1_000_000_000
_LOADED_SHARE = 0.8 * STOP_SHARE


def measured_range(
    blocks: Sequence[TickBlock],
    phases: Sequence[PhaseChange],
    sweep: Sweep,
    limits: Limits,
    device: Capabilities,
) -> SweepResult:
    """Active and passive postures of a range sweep.

    A part counts with the mean of its last 0.3 s; of one that was repeated, the last attempt. One in which
    the supervisor had to hold, yield or stop, or with a load over its limit in the last second, does not
    count at all: what hurt, and what a spasm did, is not a range.

    Args:
        blocks: All ticks of the run.
        phases: All phase changes of the run.
        sweep: What was asked for.
        limits: Limits of the run.
        device: The device that it ran on.
    """
    t_ns: Int64 = _column(blocks, "t_ns").astype(np.int64)
    q, load = _column(blocks, "q_rad"), _column(blocks, "tau_interaction_nm")
    over = (np.abs(load) / limits.tau_interaction_nm).max(axis=1) > 1.0
    lately = t_ns - np.maximum.accumulate(np.where(over, t_ns, -QUIET_NS)) < QUIET_NS
    well = _column(blocks, "safety_state") <= SafetyState.ACTIVE
    active = np.full(sweep.goals_rad.shape, np.nan)
    passive, loads = active.copy(), active.copy()
    for index, name in enumerate(sweep.postures):
        alone = part(t_ns, phases, (name, index, "patient"))
        led = part(t_ns, phases, (name, index, "robot"))
        active[index] = _end(q, t_ns, alone, well, lately)
        passive[index] = _end(q, t_ns, led, well, lately)
        loads[index] = _end(load, t_ns, led, well, lately)
    settled = part(t_ns, phases, ("approach", -1, ""))
    with np.errstate(invalid="ignore"):  # comparisons with a part that broke off are false
        low, high = device.q_min_rad + DEVICE_END_RAD, device.q_max_rad - DEVICE_END_RAD
        at_device: NDArray[np.bool_] = (passive <= low) | (passive >= high)
        loaded: NDArray[np.bool_] = np.abs(loads) >= _LOADED_SHARE * limits.tau_interaction_nm
    return SweepResult(
        joint_names=sweep.joint_names,
        side=sweep.side,
        postures=sweep.postures,
        rest_rad=_end(q, t_ns, settled, well, lately),
        active_rad=active,
        passive_rad=passive,
        load_nm=loads,
        patient_end=loaded & ~at_device,
        device_end=at_device,
        verdict=_verdict(phases),
    )


def part(t_ns: Int64, phases: Sequence[PhaseChange], key: tuple[str, int, str]) -> NDArray[np.bool_]:
    """Which ticks belong to the part with this phase, repetition and starter, (n,)."""
    inside = np.zeros(t_ns.size, dtype=np.bool_)
    ends = [phase.t_ns for phase in phases[1:]] + [np.iinfo(np.int64).max]
    for phase, end_ns in zip(phases, ends, strict=True):
        if (phase.phase, phase.repetition, phase.started_by) == key:
            inside |= (t_ns >= phase.t_ns) & (t_ns < end_ns)
    return inside


def _column(blocks: Sequence[TickBlock], name: str) -> Float64:
    """One column over all blocks, (n,) or (n, J)."""
    assert name in {entry.name for entry in fields(TickBlock)}
    values: Float64 = np.concatenate([getattr(block, name) for block in blocks])
    return values


def _end(
    values: Float64,
    t_ns: Int64,
    inside: NDArray[np.bool_],
    well: NDArray[np.bool_],
    lately: NDArray[np.bool_],
) -> Float64:
    """Mean over the end of a part, (J,); NaN where there was none or where it did not go well."""
    places = np.flatnonzero(inside)
    if not places.size:
        return np.full(values.shape[1], np.nan)
    breaks = np.flatnonzero(np.diff(places) > 1)
    last = places[breaks[-1] + 1 :] if breaks.size else places
    if not bool(well[last].all()) or bool(lately[last[-1]]):
        return np.full(values.shape[1], np.nan)
    late = last[t_ns[last] > t_ns[last[-1]] - WINDOW_NS]
    return values[late].mean(axis=0)


def _verdict(phases: Sequence[PhaseChange]) -> str:
    if any(phase.phase == "done" for phase in phases):
        return ""
    return "broken off before its end"
