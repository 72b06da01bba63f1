"""What a detector makes of visible discs, without drawing them: merged, missed, shifted, invented blobs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.levels import Level
from rehab_app.cameras.paper_markers import DISC_RADIUS_M
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64, Int64

NOBODY = -1
"""Owner of a false blob."""

_MERGE_SHARE = 0.8  # of a disc's diameter: nearer than this, two discs are one blob
_SPLIT_SHARE = 0.2  # of such pairs are told apart all the same
_DEPTH_STD_M = 0.0012  # at 0.7 m; grows with the square of the distance
_OUTLIER_M = (0.02, 0.10)
_AROUND_PX = 35.0
_NEAR_STD_M = 0.03
_FAR_M = (0.45, 1.6)
_SHOWN_SHARE = 0.9  # of the frames a persistent false blob is seen in


@dataclass(frozen=True, slots=True)
class Blobs:
    """Blobs of one frame in random order.

    Attributes:
        pixel_px: Centres, shape (D, 2).
        depth_m: Depth, NaN where there is none, shape (D,).
        owner: Marker that each is of, NOBODY for clutter, shape (D,).
        other: Second marker of a merged blob, NOBODY otherwise, shape (D,).
    """

    pixel_px: Float64
    depth_m: Float64
    owner: Int64
    other: Int64


@dataclass(frozen=True, slots=True)
class StandingClutter:
    """False blobs that stay in one place: pixels (K, 2) and depths (K,) in m."""

    pixel_px: Float64
    depth_m: Float64


def standing_clutter(
    level: Level, hand_px: Float64, hand_m: float, intrinsics: Intrinsics, rng: np.random.Generator
) -> StandingClutter:
    """Places of a level's persistent blobs in the part of the image over which the hand moves.

    Args:
        level: Says how many.
        hand_px: Markers of the open hand, shape (M, 2).
        hand_m: Their mean depth.
        intrinsics: The camera.
        rng: Draws the places.
    """
    low, high = hand_px.min(axis=0) - 60.0, hand_px.max(axis=0) + 60.0
    size = np.array([intrinsics.width_px - 1.0, intrinsics.height_px - 1.0])
    pixel = np.clip(rng.uniform(low, high, (level.persistent, 2)), 0.0, size)
    return StandingClutter(pixel, hand_m + rng.uniform(-0.08, 0.12, level.persistent))


def sense(
    level: Level,
    pixel_px: Float64,
    depth_m: Float64,
    visible: NDArray[np.bool_],
    standing: StandingClutter,
    intrinsics: Intrinsics,
    rng: np.random.Generator,
    *,
    calm: bool,
) -> Blobs:
    """Blobs of one frame.

    Args:
        level: How bad it is.
        pixel_px: Centres of what is seen of each disc, shape (M, 2).
        depth_m: Their depths, shape (M,).
        visible: Which discs are seen, shape (M,).
        standing: Persistent false blobs.
        intrinsics: The camera.
        rng: Draws everything.
        calm: Whether this is the first second, in which nothing is missed.
    """
    first, second, pixel, depth = _merged(pixel_px, depth_m, np.flatnonzero(visible), intrinsics, rng)
    kept = np.flatnonzero((rng.random(len(first)) >= level.miss_share) | calm)
    pixel, depth = pixel[kept], _measured(depth[kept], level, rng)
    false_px, false_m = _false_blobs(level, pixel_px, float(depth_m.mean()), standing, intrinsics, rng)
    pixel = np.concatenate([pixel + rng.normal(0.0, level.centre_std_px, pixel.shape), false_px])
    nobody = np.full(len(false_px), NOBODY, dtype=np.int64)
    order = rng.permutation(len(pixel))
    return Blobs(
        pixel[order],
        np.concatenate([depth, false_m])[order],
        np.concatenate([first[kept], nobody])[order],
        np.concatenate([second[kept], nobody])[order],
    )


def _merged(
    pixel_px: Float64, depth_m: Float64, seen: Int64, intrinsics: Intrinsics, rng: np.random.Generator
) -> tuple[Int64, Int64, Float64, Float64]:
    """Close pairs made one blob: first and second owner, centre (D, 2), depth (D,)."""
    first, second = seen.copy(), np.full(len(seen), NOBODY, dtype=np.int64)
    pixel, depth = pixel_px[seen], depth_m[seen]
    apart = np.linalg.norm(pixel[:, None] - pixel, axis=2) + 1e9 * np.tri(len(seen))
    across = 2.0 * DISC_RADIUS_M * np.sqrt(intrinsics.fx_px * intrinsics.fy_px) / depth_m.mean()
    used = np.zeros(len(seen), dtype=np.bool_)
    gone = used.copy()
    for a, b in np.argwhere(apart < _MERGE_SHARE * across):
        if used[a] or used[b] or rng.random() < _SPLIT_SHARE:
            continue
        near, far = (a, b) if depth[a] <= depth[b] else (b, a)
        weight = rng.uniform(0.5, 0.9)  # the nearer paper covers part of the farther
        pixel[near] = weight * pixel[near] + (1.0 - weight) * pixel[far]
        depth[near] = weight * depth[near] + (1.0 - weight) * depth[far]
        second[near] = seen[far]
        used[[a, b]], gone[far] = True, True
    return first[~gone], second[~gone], pixel[~gone], depth[~gone]


def _measured(depth_m: Float64, level: Level, rng: np.random.Generator) -> Float64:
    """Depths with noise, outliers and holes, shape (D,)."""
    count = len(depth_m)
    noisy = depth_m + rng.normal(0.0, _DEPTH_STD_M, count) * (depth_m / 0.7) ** 2
    wrong = rng.random(count) < level.outlier_share
    error = rng.uniform(*_OUTLIER_M, count) * rng.choice((-1.0, 1.0), count)
    return np.where(rng.random(count) < level.hole_share, np.nan, noisy + wrong * error)


def _false_blobs(
    level: Level,
    hand_px: Float64,
    hand_m: float,
    standing: StandingClutter,
    intrinsics: Intrinsics,
    rng: np.random.Generator,
) -> tuple[Float64, Float64]:
    """Pixels (K, 2) and depths (K,) of clutter: anywhere, near the hand, and what stays."""
    size = np.array([intrinsics.width_px - 1.0, intrinsics.height_px - 1.0])
    anywhere, near = (int(count) for count in rng.poisson(0.5 * level.clutter, 2))
    low, high = hand_px.min(axis=0) - _AROUND_PX, hand_px.max(axis=0) + _AROUND_PX
    shown = rng.random(len(standing.depth_m)) < _SHOWN_SHARE
    still_px = standing.pixel_px[shown]
    still_px = still_px + rng.normal(0.0, level.centre_std_px, still_px.shape)
    pixel = np.concatenate(
        [rng.uniform(0.0, size, (anywhere, 2)), rng.uniform(low, high, (near, 2)), still_px]
    )
    depth = np.concatenate([rng.uniform(*_FAR_M, anywhere), rng.normal(hand_m, _NEAR_STD_M, near)])
    still_m = _measured(standing.depth_m[shown], level, rng)
    holes = rng.random(len(depth)) < level.hole_share
    return np.clip(pixel, 0.0, size), np.concatenate([np.where(holes, np.nan, depth), still_m])
