"""What happens in one episode: patient, order, faults and people's acts, all of it drawn from one seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.runtime import Advance, Order, Pain, Pause, Reset, Resume, Reverse, SetSpeed
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, Fault, simulated_capabilities
from robot_iface.sim.faults import FaultKind
from robot_iface.types import (
    MODES,
    SPACES,
    VIRTUAL_KINDS,
    Float64,
    PatientTwin,
    Plan,
    Prescription,
    ReferencePath,
    Spasm,
    Sweep,
)

DEVICE_FAULTS: tuple[FaultKind, ...] = (
    *("freeze", "delayed", "lost", "reordered", "nan", "inf", "stuck", "sensor-offset", "wrong-sign"),
    *("wrong-sign-interaction", "over-temperature", "device-fault", "read-error", "write-error", "spasm"),
)
LOOP_FAULTS = (
    *("app-frozen", "operator-gone", "overruns", "clock-forward", "clock-backward", "stall"),
    *("stop", "mad-nan", "mad-inf", "mad-torque", "mad-step", "mad-push", "mad-push", "load", "load"),
    *("enable-error", "brake-error", "power-error", "clear-error", "open-error", "close-error"),
)
ORDERS: tuple[Order, ...] = (
    *(Pause(), Resume(), Resume(), Reverse(), Advance(), Advance(), SetSpeed(0.2), SetSpeed(0.9), Pain()),
    *(Reset(), Reset(), Resume()),
)
LONGEST_S = 8.0
_SPASTIC = ("mas1+", "mas2", "mas3", "clonus", "contracture")


@dataclass(frozen=True, slots=True)
class Trouble:
    """A fault outside the device: what, from which tick on, for how many ticks, and how much."""

    kind: str
    start: int
    ticks: int
    size: float

    @property
    def sign(self) -> float:
        """Which way it goes, where it has a direction."""
        return 1.0 if round(1e5 * self.size) % 2 else -1.0

    def active(self, tick: int) -> bool:
        return self.start <= tick < self.start + self.ticks


@dataclass(frozen=True, slots=True)
class Script:
    """An episode. ``orders`` are pairs of time in s and order; ``end_s`` is when the stop is pressed."""

    seed: int
    plan: Plan
    faults: tuple[Fault, ...]
    troubles: tuple[Trouble, ...]
    orders: tuple[tuple[float, Order], ...]
    end_s: float

    @property
    def clean(self) -> bool:
        """Whether nothing misleads the sensors or pulls the hand, so that it must stay in its range."""
        misled = {"stuck", "sensor-offset", "wrong-sign", "spasm"}
        return not (self.plan.twin.spasms or misled & {fault.kind for fault in self.faults})

    def kinds(self) -> list[str]:
        """Every fault that is planned."""
        return [fault.kind for fault in self.faults] + [trouble.kind for trouble in self.troubles]


def draw(seed: int) -> Script:
    """The episode of a seed."""
    rng = np.random.default_rng(seed)
    end_s = float(rng.uniform(3.0, LONGEST_S))
    plan = _plan(rng, seed)
    faults = tuple(_fault(rng, plan.joint_names, end_s) for _ in range(int(rng.integers(0, 3))))
    troubles = tuple(_trouble(rng, end_s) for _ in range(int(rng.integers(0, 4))))
    return Script(seed, plan, faults, troubles, _orders(rng, end_s), end_s)


def _orders(rng: np.random.Generator, end_s: float) -> tuple[tuple[float, Order], ...]:
    """Orders at any time, and often the right ones after something has held the run: reset, then resume."""
    times = rng.uniform(0.0, end_s, int(rng.integers(0, 9))).tolist()
    orders = [(float(t_s), ORDERS[int(rng.integers(len(ORDERS)))]) for t_s in times]
    if rng.random() < 0.4:
        t_s = float(rng.uniform(0.3, end_s))
        orders += [(t_s, Pain()), (t_s + 0.5, Reset()), (t_s + 0.8, Resume()), (t_s + 1.5, Reset())]
        orders += [(t_s + 1.8, Resume())]
    return tuple(sorted(orders, key=lambda order: order[0]))


def _plan(rng: np.random.Generator, seed: int) -> Plan:
    device = "dlr-hit-ii" if rng.random() < 0.15 else "exoskeleton"
    can = simulated_capabilities(device)
    kind = VIRTUAL_KINDS[int(rng.integers(len(VIRTUAL_KINDS)))]
    side = "left" if rng.random() < 0.5 else "right"
    spasms = ()
    if rng.random() < 0.3:
        start, lasts, size = rng.uniform([0.5, 0.1, 0.1], [LONGEST_S, 3.0, 0.9]).tolist()
        spasms = (Spasm(start, lasts, size, "", 6.0 if rng.random() < 0.3 else 0.0),)
    ordered = Prescription(
        MODES[int(rng.integers(len(MODES)))],
        float(rng.uniform(0.1, 1.0)),
        int(rng.integers(1, 4)),
        float(rng.uniform(0.3, 6.0)),
        hold_s=0.2,
        rest_s=0.2,
        cue_timeout_s=1.0,
        space=SPACES[int(rng.integers(len(SPACES)))] if device == "exoskeleton" else "joint",
        warm_up_repetitions=int(rng.integers(0, 2)),
    )
    sweep = _sweep(rng, side) if device == "exoskeleton" and rng.random() < 0.2 else None
    return Plan(
        device=device,
        path=None if sweep else _fist(rng, can.joint_names, side),
        prescription=ordered,
        limits=shipped_limits(
            can.joint_names, can.q_min_rad, can.q_max_rad, spastic=kind in _SPASTIC, halved=rng.random() < 0.2
        ),
        twin=PatientTwin(kind, side, float(rng.uniform(0.16, 0.21)), spasms=spasms),
        seed=seed,
        software_version="0",
        realtime=bool(rng.random() < 0.7),
        sweep=sweep,
    )


def _fist(rng: np.random.Generator, names: tuple[str, ...], side: str) -> ReferencePath:
    """Closing and opening again, minimum jerk, every joint to its own depth."""
    t_s = np.linspace(0.0, float(rng.uniform(1.5, 3.0)), 61)
    u = 1.0 - np.abs(np.linspace(-1.0, 1.0, 61))
    closing = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    depth = np.array([0.0 if "abduction" in name else float(rng.uniform(8.0, 35.0)) for name in names])
    start = np.array([0.0 if "abduction" in name else float(rng.uniform(5.0, 30.0)) for name in names])
    angles: Float64 = np.deg2rad(start + closing[:, None] * depth)
    return ReferencePath(names, t_s, angles, "0" * 64, "left" if side == "left" else "right")


def _sweep(rng: np.random.Generator, side: str) -> Sweep:
    """A guided run without a path."""
    goals = np.deg2rad(rng.uniform(0.0, 45.0, (2, len(DRIVEN))))
    hand = "left" if side == "left" else "right"
    return Sweep("range", DRIVEN, hand, ("open", "fist"), goals, speed_rad_s=0.35, timeout_s=5.0)


_SIZES = {
    "delayed": (1.0, 20.0),
    "lost": (1.0, 5.0),
    "sensor-offset": (-0.3, 0.3),
    "over-temperature": (75.0, 95.0),
    "spasm": (0.05, 0.9),
}


def _fault(rng: np.random.Generator, names: tuple[str, ...], end_s: float) -> Fault:
    kind = DEVICE_FAULTS[int(rng.integers(len(DEVICE_FAULTS)))]
    joint = names[int(rng.integers(len(names)))] if rng.random() < 0.6 else ""
    lasts = float(rng.choice([0.001, 0.01, 0.1, 1.0, np.inf]))
    size = float(rng.uniform(*_SIZES.get(kind, (0.0, 1.0))))
    return Fault(kind, float(rng.uniform(0.0, end_s)), lasts, joint, size)


def _trouble(rng: np.random.Generator, end_s: float) -> Trouble:
    kind = LOOP_FAULTS[int(rng.integers(len(LOOP_FAULTS)))]
    start = int(rng.uniform(0, end_s * 1e3))
    if kind in ("mad-push", "load"):
        return Trouble(kind, start, int(rng.choice([5, 40, 300, 1000])), float(rng.uniform()))
    if kind.endswith("-error"):  # what is seldom asked of a device must fail for long to be seen failing
        return Trouble(kind, int(rng.choice([0, start])), 100_000, 1.0)
    if kind in ("app-frozen", "operator-gone"):  # most of them for longer than is borne
        return Trouble(kind, start, int(rng.choice([200, 400, 3000])), 1.0)
    return Trouble(kind, start, int(rng.choice([1, 5, 100, 2000])), float(rng.uniform()))
