"""The long run of the fault fuzz: ``make fuzz``, that is ``python -m tests.bench.motion.fuzz``."""

from __future__ import annotations

import contextlib
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from tests.fuzz.episode import Played, play

TICKS = 1_000_000
REPLAY_EVERY = 25
"""Every so many episodes one is played again: its digest must be the same."""


@dataclass
class Tally:
    """What came of many episodes."""

    episodes: int = 0
    ticks: int = 0
    replayed: int = 0
    reversals: int = 0
    outside_rad: float = 0.0
    planted: Counter[str] = field(default_factory=Counter)
    states: Counter[str] = field(default_factory=Counter)
    causes: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)

    def add(self, played: Played) -> None:
        """Count one episode."""
        self.episodes += 1
        self.ticks += played.ticks
        self.reversals += played.reversals
        self.outside_rad = max(self.outside_rad, played.outside_rad)
        self.planted.update(played.script.kinds())
        self.states.update(played.states)
        self.causes.update(cause.split()[0] for cause in played.causes)
        if played.refused:
            self.refused[played.refused] += 1
        self.failures += played.failures

    def report(self) -> str:
        """The tally as a person reads it."""
        lines = [
            f"{self.ticks} control ticks in {self.episodes} episodes, {self.replayed} of them played twice",
            f"planted: {_counted(self.planted)}",
            f"episodes that reached: {_counted(self.states)}",
            f"transitions by cause: {_counted(self.causes)}; {self.reversals} reversals on a load",
            f"refused before motion: {_counted(self.refused)}",
            f"powered true hand outside its range by {np.rad2deg(self.outside_rad):.1f} degrees at most",
            *self.failures,
            f"failures: {len(self.failures)}",
        ]
        return "\n".join(lines)


def _counted(counter: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in sorted(counter.items())) or "none"


def fuzz(ticks: int = TICKS, first_seed: int = 0) -> Tally:
    """Play episodes until so many control ticks have been judged."""
    tally, seed = Tally(), first_seed
    while tally.ticks < ticks:
        played = play(seed)
        tally.add(played)
        if seed % REPLAY_EVERY == 0:
            tally.replayed += 1
            if play(seed).digest != played.digest:
                tally.failures.append(f"seed {seed}: played again, it is another run")
        seed += 1
    return tally


def main() -> int:
    """Run and report; the exit code says whether anything failed."""
    ticks = int(sys.argv[1]) if len(sys.argv) > 1 else TICKS
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):  # the engine writes warnings here
        tally = fuzz(ticks)
    sys.stdout.write(tally.report() + "\n")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    raise SystemExit(main())
