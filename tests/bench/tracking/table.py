"""Every method over the same sequences: what the tables of ``docs/benchmarks.md`` are made of."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

from rehab_app.cameras.sequence import PointSequence, point_sequence
from tests.bench.tracking.peers import hungarian_2d, hungarian_3d, oracle
from tests.bench.tracking.run import run_tracker
from tests.bench.tracking.score import Score, Tracks, score
from tests.bench.tracking.stone_soup import stone_soup_gnn, stone_soup_jpda

Follow = Callable[[PointSequence], Tracks]

SEEDS = (100, 101, 102, 103, 104)
"""Never tuned on."""
FRAMES = 900
SLICE = 200
"""Frames for the methods that take tens of milliseconds each."""


@dataclass(frozen=True)
class Method:
    """A tracker under test."""

    name: str
    follow: Follow
    frames: int = FRAMES


@dataclass(frozen=True)
class Row:
    """Figures of one method at one level: medians over the seeds, swaps summed over them."""

    method: str
    level: str
    scores: tuple[Score, ...]
    ms: float

    @property
    def idf1(self) -> float:
        return median(one.idf1 for one in self.scores)

    @property
    def rmse_px(self) -> float:
        return median(one.rmse_px for one in self.scores)

    @property
    def swaps(self) -> int:
        return sum(one.swaps for one in self.scores)

    def line(self) -> str:
        """One row of a Markdown table."""
        lowest, highest = min(one.idf1 for one in self.scores), max(one.idf1 for one in self.scores)
        switches = sum(one.switches for one in self.scores) / sum(one.frames for one in self.scores)
        cells = [
            self.method,
            self.level,
            f"{median(one.mota for one in self.scores):.3f}",
            f"{self.idf1:.3f} ({lowest:.3f}-{highest:.3f})",
            f"{median(one.hota for one in self.scores):.3f}",
            f"{1000 * switches:.0f}",
            f"{self.swaps}",
            f"{self.rmse_px:.2f}",
            f"{self.ms:.2g}",
        ]
        return "| " + " | ".join(cells) + " |"


HEAD = (
    "| method | level | MOTA | IDF1 (range) | HOTA | switches per 1000 frames | true swaps, all seeds "
    "| RMSE px | ms per frame, CPU |\n|---|---|---|---|---|---|---|---|---|"
)


def ours(name: str) -> Follow:
    """One of the product's trackers as a method."""
    return lambda sequence: run_tracker(name, sequence).tracks


METHODS = (
    Method("kinematic", ours("kinematic")),
    Method("rbmcda", ours("rbmcda")),
    Method("thesis, literal", ours("rbmcda-literal")),
    Method("Hungarian + Kalman, 2-D", hungarian_2d),
    Method("Hungarian + Kalman, 3-D", hungarian_3d),
    Method("Stone Soup GNN", stone_soup_gnn, SLICE),
    Method("Stone Soup JPDA", stone_soup_jpda, SLICE),
    Method("perfect association", oracle),
)


def measured(
    method: Method, label: str, sequences: Callable[[int], PointSequence], seeds: tuple[int, ...] = SEEDS
) -> Row:
    """A method over the sequences of some seeds."""
    scores: list[Score] = []
    spent, frames = 0.0, 0
    for seed in seeds:
        sequence = sequences(seed)
        start = time.process_time()
        tracks = method.follow(sequence)
        spent += time.process_time() - start
        frames += len(sequence.t_ns)
        scores.append(score(sequence, tracks))
    return Row(method.name, label, tuple(scores), 1e3 * spent / frames)


def at_level(method: Method, level: str, seeds: tuple[int, ...] = SEEDS) -> Row:
    """A method at a level."""
    return measured(method, level, lambda seed: point_sequence(level, seed, method.frames), seeds)
