"""Scores tracks against truth by the usual counts of multi-object tracking, over visible markers only.

A marker counts while the tracking camera can see it. A track is reported while it has a detection and for at
most three captures after. Match radius 8 px. Frames that never came are left out. Before matching, a report
that matches no visible marker and lies where a hidden one truly is (or is of a marker whose place the truth
itself does not know) is set aside: it is neither right nor wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import motmetrics
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from rehab_app.cameras.sequence import PointSequence
from sessions.records.fields import Float64, Int64

RADIUS_PX = 8.0
COAST = 3
SWAP_FRAMES = 5

Bool = NDArray[np.bool_]


@dataclass(frozen=True)
class Tracks:
    """What a tracker says of F frames and M markers.

    Attributes:
        pixel_px: Where it says each marker is, NaN where it does not say, shape (F, M, 2).
        detection: Row of the detection that each marker was given, -1 where none, shape (F, M).
    """

    pixel_px: Float64
    detection: Int64


@dataclass(frozen=True)
class Score:
    """How good tracks are.

    Attributes:
        mota, idf1, hota: 1 is perfect.
        switches: Identity switches.
        swaps: Labels that sat on another marker's blob for at least five frames.
        rmse_px: Error of the reported centres of visible markers; a lost label counts with where it is.
        frames: Frames that came.
    """

    mota: float
    idf1: float
    hota: float
    switches: int
    swaps: int
    rmse_px: float
    frames: int


def score(sequence: PointSequence, tracks: Tracks, *, set_aside: bool = True) -> Score:
    """Score tracks of the tracking camera; with ``set_aside`` False, a report of a hidden marker is false."""
    came = np.flatnonzero(~sequence.dropped)
    truth, visible = sequence.pixel_px[came], sequence.visible[came]
    said, reported = tracks.pixel_px[came], reported_tracks(tracks, came)
    accumulator = motmetrics.MOTAccumulator(auto_id=True)
    costs: list[Float64] = []
    for frame in range(len(came)):
        seen, cost = np.flatnonzero(visible[frame]), distances_px(truth[frame], said[frame])
        kept = np.flatnonzero(reported[frame])
        if set_aside:
            kept = kept[~_on_hidden(cost, visible[frame], np.isfinite(truth[frame, :, 0]), kept)]
        cost = np.where(cost <= RADIUS_PX, cost, np.nan)
        accumulator.update(seen, kept, cost[np.ix_(seen, kept)])
        sparse = np.full(cost.shape, np.inf)
        sparse[np.ix_(seen, kept)] = np.nan_to_num(cost[np.ix_(seen, kept)], nan=np.inf)
        costs.append(sparse)
        reported[frame] = np.isin(np.arange(reported.shape[1]), kept)
    host = motmetrics.metrics.create()
    table = host.compute(accumulator, metrics=["mota", "idf1", "num_switches"], name="all")
    values = table.loc["all"]
    said_visible = visible & np.isfinite(said).all(axis=2)
    errors = np.linalg.norm(said - truth, axis=2)[said_visible]
    return Score(
        mota=float(values["mota"]),
        idf1=float(values["idf1"]),
        hota=hota(np.array(costs), visible, reported),
        switches=int(values["num_switches"]),
        swaps=true_swaps(sequence, tracks),
        rmse_px=float(np.sqrt(np.mean(errors**2))) if len(errors) else float("nan"),
        frames=len(came),
    )


def reported_tracks(tracks: Tracks, came: Int64) -> Bool:
    """Which tracks count as reported in each frame that came, shape (C, M)."""
    given = tracks.detection[came] >= 0
    frame = np.arange(len(came))[:, None]
    last = np.maximum.accumulate(np.where(given, frame, -COAST - 1), axis=0)
    reported: Bool = (frame - last <= COAST) & np.isfinite(tracks.pixel_px[came]).all(axis=2)
    return reported


def distances_px(truth_px: Float64, said_px: Float64) -> Float64:
    """Distance of every pair, truth by track, shape (M, M); infinite where nothing is said."""
    apart = np.linalg.norm(truth_px[:, None] - said_px[None], axis=2)
    return np.nan_to_num(apart, nan=np.inf)


def _on_hidden(cost: Float64, visible: Bool, known: Bool, kept: Int64) -> Bool:
    """Which of the kept tracks match no visible marker and lie on a hidden one, or on one not known, (K,)."""
    seen, hidden = np.flatnonzero(visible), np.flatnonzero(~visible)
    near = np.where(cost[np.ix_(seen, kept)] <= RADIUS_PX, cost[np.ix_(seen, kept)], 1e6)
    rows, columns = linear_sum_assignment(near)
    matched = np.zeros(len(kept), dtype=np.bool_)
    matched[columns[near[rows, columns] <= RADIUS_PX]] = True
    there = (cost[np.ix_(hidden, kept)] <= RADIUS_PX).any(axis=0) | ~known[kept]
    aside: Bool = ~matched & there
    return aside


def true_swaps(sequence: PointSequence, tracks: Tracks) -> int:
    """How often a label settled on another marker's blob: at least five detections of it in a row."""
    swaps = 0
    for marker in range(len(sequence.protocol.names)):
        run = 0
        for frame in np.flatnonzero(~sequence.dropped):
            row = int(tracks.detection[frame, marker])
            if row < 0:
                continue
            owners = (int(sequence.owner[frame][row]), int(sequence.other[frame][row]))
            run = run + 1 if owners[0] >= 0 and marker not in owners else 0
            swaps += run == SWAP_FRAMES
    return swaps


def hota(costs_px: Float64, visible: Bool, reported: Bool) -> float:
    """Higher-order tracking accuracy at the match radius.

    Luiten et al. (2021), doi 10.1007/s11263-020-01375-2.

    Args:
        costs_px: Distance of every allowed pair of truth and track, infinite elsewhere, shape (F, M, M).
        visible: Truth that counts, shape (F, M).
        reported: Tracks that count, shape (F, M).
    """
    possible = costs_px <= RADIUS_PX
    ever = possible.sum(axis=0)
    union = visible.sum(axis=0)[:, None] + reported.sum(axis=0)[None] - ever
    alignment = ever / np.maximum(union, 1)
    together = np.zeros(alignment.shape)
    matches = 0
    for frame in range(len(costs_px)):
        likeness = np.where(possible[frame], 1.0 - costs_px[frame] / (2.0 * RADIUS_PX), 0.0)
        gain = np.where(possible[frame], 1e-6 + alignment * likeness, 0.0)
        rows, columns = linear_sum_assignment(-gain)
        good = possible[frame][rows, columns]
        together[rows[good], columns[good]] += 1.0
        matches += int(good.sum())
    if not matches:
        return 0.0
    share = together / np.maximum(visible.sum(axis=0)[:, None] + reported.sum(axis=0)[None] - together, 1.0)
    association = float((together * share).sum() / matches)
    detection = matches / (int(visible.sum()) + int(reported.sum()) - matches)
    return float(np.sqrt(detection * association))
