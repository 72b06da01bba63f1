"""How noisy detections are, where their file does not say: as usual, unless they jitter more than that.

A marker that is seen in three frames running moves almost evenly, so its second difference is noise: of
variance 6 sigma squared. The median over all such triples is hardly touched by clutter and by quick moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.recording.archive import Archive
from rehab_app.recording.detections_check import column
from sessions.errors import Refused
from sessions.records.fields import Float64, Int64

USUAL_PX = 0.6
USUAL_M = 0.003
"""Noise of usual detections, the skin's movement under a marker included."""
_WORSE_PX = (1.5, 3.0)
_WORSE_M = (0.003, 0.01)  # noise that is worse than usual counts as it is, within these bounds
_STEP_PX = 12.0  # a marker that moved farther from one frame to the next tells nothing
_FEWEST = 60  # triples without which the usual figures hold
_FRAMES = 200  # that are looked at: from the start, where the hand is usually still
_MAD = 1.4826


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise of each detection.

    Attributes:
        pixel_std_px: Standard deviation of u and of v, shape (D,).
        depth_std_m: Standard deviation of the depth, shape (D,).
    """

    pixel_std_px: Float64
    depth_std_m: Float64


def noise_of(
    held: Archive, t_s: Float64, frame: Int64, pixel_px: Float64, depth_m: Float64, order: Int64
) -> Noise:
    """Noise as the file states it, else as its first frames show it.

    Raises:
        Refused: A stated deviation is not above 0.
    """
    measured = _measured(frame, pixel_px, depth_m, order, len(t_s))
    stds: list[Float64] = []
    for name, value in zip(("pixel_std_px", "depth_std_m"), measured, strict=True):
        std = np.full(len(frame), value)
        if name in held:
            std = column(held, name, len(frame))
            known = np.isfinite(depth_m) if name == "depth_std_m" else np.ones(len(frame), dtype=np.bool_)
            if not bool((std[known] > 0).all()):
                raise Refused(f"{held.thing}, {name}", "not above 0", "above 0", "mend it")
            std = np.where(known, std, value)
        stds.append(std)
    return Noise(stds[0], stds[1])


def _measured(
    frame: Int64, pixel_px: Float64, depth_m: Float64, order: Int64, frames: int
) -> tuple[float, float]:
    """Pixel and depth deviation from second differences over triples of frames."""
    edges = np.searchsorted(frame[order], np.arange(frames + 1))
    rows = [order[edges[index] : edges[index + 1]] for index in range(min(frames, _FRAMES))]
    bends: list[Float64] = []
    depths: list[Float64] = []
    for before, here, after in zip(rows, rows[1:], rows[2:], strict=False):
        back, on = _nearest(pixel_px, here, before), _nearest(pixel_px, here, after)
        both = (back >= 0) & (on >= 0)
        middle, first, last = here[both], back[both], on[both]
        bends.append((pixel_px[first] - 2.0 * pixel_px[middle] + pixel_px[last]).ravel())
        depths.append(depth_m[first] - 2.0 * depth_m[middle] + depth_m[last])
    return (
        _deviation(bends, 2 * _FEWEST, USUAL_PX, _WORSE_PX),
        _deviation(depths, _FEWEST, USUAL_M, _WORSE_M),
    )


def _nearest(pixel_px: Float64, here: Int64, there: Int64) -> Int64:
    """Row of each one's nearest in the other frame, -1 unless both are each other's and near."""
    if not here.size or not there.size:
        return np.full(len(here), -1, dtype=np.int64)
    square = ((pixel_px[here][:, None] - pixel_px[there]) ** 2).sum(axis=2)
    best = square.argmin(axis=1)
    mutual = square.argmin(axis=0)[best] == np.arange(len(here))
    near = square[np.arange(len(here)), best] < _STEP_PX**2
    return np.where(mutual & near, there[best], -1)


def _deviation(bends: list[Float64], fewest: int, usual: float, worse: tuple[float, float]) -> float:
    """The usual deviation, unless these second differences tell of a worse one."""
    values = np.concatenate(bends) if bends else np.zeros(0)
    values = values[np.isfinite(values)]
    if values.size < fewest:
        return usual
    met = float(_MAD * np.median(np.abs(values)) / np.sqrt(6.0))
    return min(met, worse[1]) if met > worse[0] else usual
