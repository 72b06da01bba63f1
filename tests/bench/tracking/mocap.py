"""A real hand under motion capture as a camera would see it: 13 markers, no occlusion, real movement."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.blob_sensor import NOBODY
from rehab_app.cameras.levels import Level
from rehab_app.cameras.sequence import PointSequence
from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from rehab_app.geometry.view import PRIMARY
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.importers.qualisys import read_qualisys
from sessions.records.fields import Float64, Int64

RATE_HZ = 30.0
DISTANCE_M = 0.7
NOISE_PX = 0.6
NOISE_M = 0.0006
MISS_SHARE = 0.03
FALSE_BLOBS = 2
AROUND_PX = 80.0
AROUND_M = 0.020

CLEAN = Level("mocap clean", 1.0, 1.0, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NOISY = Level("mocap noisy", 1.0, 1.0, MISS_SHARE, NOISE_PX, FALSE_BLOBS, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def mocap_sequence(
    shared_data: Path,
    seed: int,
    *,
    noisy: bool = True,
    side_of_axis: int = 1,
    frames: int | None = None,
    intrinsics: Intrinsics = KINECT,
) -> PointSequence:
    """The recording ``mocap_hand_dfki`` at 30 Hz from a still camera 0.7 m from the hand's mean place.

    Args:
        shared_data: Folder of the real recordings.
        seed: Of noise, misses and false blobs.
        noisy: With .6 px and .6 mm of noise, 3 % missed, 2 false blobs a frame; or none of it.
        side_of_axis: 1 or -1: on which side of the hand the camera stands.
        frames: Captures to take; all 1350 if None.
        intrinsics: The camera.
    """
    protocol = load_protocol("mocap13")
    series = read_qualisys(shared_data / "mocap_hand_dfki" / "recording.tsv").series
    columns = [series.names.index(name) for name in protocol.names]
    t_s = np.arange(0.0, series.t_s[-1], 1.0 / RATE_HZ)[:frames]
    nearest = np.abs(series.t_s[:, None] - t_s).argmin(axis=0)
    points = _before_camera(series.p_camera_m[:, columns], side_of_axis)[nearest]
    pixel = intrinsics.project(points)
    visible = np.isfinite(points).all(axis=2)
    rng = np.random.default_rng([seed, 31])
    shots = [
        _shot(pixel[k], points[k], visible[k], round(1e9 * t_s[k]), noisy, intrinsics, rng)
        for k in range(len(t_s))
    ]
    nobody = tuple(np.full(len(owner), NOBODY, dtype=np.int64) for _, owner in shots)
    return PointSequence(
        NOISY if noisy else CLEAN,
        protocol,
        "right",
        intrinsics,
        (PRIMARY,),
        np.rint(1e9 * t_s).astype(np.int64),
        tuple(detections for detections, _ in shots),
        tuple(owner for _, owner in shots),
        nobody,
        np.zeros(len(t_s), dtype=np.bool_),
        pixel,
        points,
        visible,
        pixel[None],
        visible[None],
        np.full((len(t_s), 21), np.nan),
        np.full((len(t_s), 25, 3), np.nan),
        pixel[0],
    )


def _before_camera(p_m: Float64, side_of_axis: int) -> Float64:
    """Points (F, M, 3) in the frame of a camera that looks along the axis of least variance."""
    known = p_m[np.isfinite(p_m).all(axis=2)]
    _, axes = np.linalg.eigh(np.cov(known.T))  # columns by rising variance
    forward, right = side_of_axis * axes[:, 0], axes[:, 2]
    rotation = np.stack([right, np.cross(forward, right), forward])
    return (p_m - known.mean(axis=0)) @ rotation.T + np.array([0.0, 0.0, DISTANCE_M])


def _shot(
    pixel_px: Float64,
    p_camera_m: Float64,
    visible: NDArray[np.bool_],
    t_ns: int,
    noisy: bool,
    intrinsics: Intrinsics,
    rng: np.random.Generator,
) -> tuple[Detections, Int64]:
    """Detections of one frame in random order and the marker of each."""
    owner = np.flatnonzero(visible)
    if noisy:
        owner = owner[(rng.random(len(owner)) >= MISS_SHARE) | (t_ns == 0)]
    pixel, depth = pixel_px[owner], p_camera_m[owner, 2]
    if noisy:
        pixel = pixel + rng.normal(0.0, NOISE_PX, pixel.shape)
        depth = depth + rng.normal(0.0, NOISE_M, depth.shape)
        beside = pixel_px[rng.choice(np.flatnonzero(visible), FALSE_BLOBS)]
        middle = float(np.nanmean(p_camera_m[:, 2]))
        pixel = np.concatenate([pixel, beside + rng.uniform(-AROUND_PX, AROUND_PX, beside.shape)])
        depth = np.concatenate([depth, middle + rng.uniform(-AROUND_M, AROUND_M, FALSE_BLOBS)])
        owner = np.concatenate([owner, np.full(FALSE_BLOBS, NOBODY)])
    order = rng.permutation(len(owner))
    count = len(order)
    detections = lifted(
        t_ns,
        pixel[order],
        depth[order],
        intrinsics,
        pixel_std_px=np.full(count, 0.6),
        depth_std_m=np.full(count, 0.002),
        similarity=np.ones(count),
    )
    return detections, owner[order]
