"""From a sighting to places in space: the image says where, depth or the network how far.

A landmark is a joint within the finger, a depth image shows the skin before it. Where another bone of the
hand lies before a landmark, neither the picture nor its depth is that of the landmark: it is a guess and
marked so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.vision.markerless.landmarker import POINTS, HandSighting
from sessions.records.fields import Float64

Flags = NDArray[np.bool_]

GUESSED = 0.3
"""Factor on the similarity of a landmark that is hidden."""

_SKIN_M = np.array([0.015, 0.013, 0.011, 0.009, 0.007, *([0.011, 0.008, 0.007, 0.006] * 4)])
_BONES = np.array([(0 if point % 4 == 1 else point - 1, point) for point in range(1, POINTS)])
_FINGER_M = 0.008  # half of a finger's thickness
_ACROSS_M = 0.003  # how far a landmark lies beside the joint, seen
_ACROSS_HIDDEN_M = 0.008
_SKIN_STD_M = 0.004  # of a joint beneath skin whose depth was measured
_NETWORK_STD_M = 0.005  # of the network's depth within the hand
_HIDDEN_STD_M = 0.016
_PATCH_M = 0.003
_AGREE_M = 0.03  # depth that differs more from the network's is that of something else
_FEWEST = 6  # landmarks with depth that make a hand metric
_SLOPES = np.eye(2)


@dataclass(frozen=True, slots=True)
class _Depths:
    """Depth of the landmarks along the optical axis and its standard deviation, shape (21,) each."""

    depth_m: Float64
    std_m: Float64


def located(
    sighting: HandSighting, depth_m: NDArray[np.float32] | None, intrinsics: Intrinsics, view: View = PRIMARY
) -> Detections:
    """The 21 landmarks of a sighting as detections, row by row in their order.

    Without depth the points follow the network's guess of the hand's size: right in shape and in the image,
    not in scale. Their covariance then is that within the hand.

    Args:
        sighting: The hand in the image.
        depth_m: Depth registered to it, shape (H, W), 0 or NaN where there is none; None without a sensor.
        intrinsics: Camera of both.
        view: Where the camera stands.
    """
    hand_m = guessed_hand(sighting, intrinsics)
    guess_m = hand_m[:, 2]
    skin_m = None if depth_m is None else skin_depth(depth_m, sighting.pixel_px, guess_m, intrinsics)
    scale = 1.0 if skin_m is None else _scale(skin_m, guess_m)
    unscaled = not np.isfinite(scale)
    scale = 1.0 if unscaled else scale
    behind = hidden(sighting.pixel_px, scale * guess_m, intrinsics)
    found = _depths(scale * guess_m, skin_m, behind)
    across_m = np.where(behind, _ACROSS_HIDDEN_M, _ACROSS_M)
    focal_px = np.sqrt(intrinsics.fx_px * intrinsics.fy_px)
    detections = lifted(
        sighting.t_ns,
        sighting.pixel_px,
        found.depth_m,
        intrinsics,
        pixel_std_px=across_m * focal_px / found.depth_m,
        depth_std_m=found.std_m,
        similarity=sighting.score * np.where(behind | unscaled, GUESSED, 1.0),
        view=view,
    )
    if depth_m is not None:
        return detections
    # the network's places in space agree with each other better than with its pixels
    guessed = hand_m @ view.rotation_tracking_camera.T + view.p_tracking_camera_m
    return replace(detections, p_camera_m=guessed)


def guessed_hand(sighting: HandSighting, intrinsics: Intrinsics) -> Float64:
    """The network's hand put where it covers its pixels, in the camera frame, shape (21, 3), m.

    The network looks along the ray to the hand: its axes are turned there. The hand's place follows from all
    pixels by linear least squares.
    """
    ray = intrinsics.lift(sighting.pixel_px, np.ones(POINTS))
    hand_m = sighting.world_m @ _facing(ray.mean(axis=0)).T
    slopes = np.zeros((POINTS, 2, 3))
    slopes[:, :, :2], slopes[:, :, 2] = _SLOPES, -ray[:, :2]
    known = ray[:, :2] * hand_m[:, 2:] - hand_m[:, :2]
    place, *_ = np.linalg.lstsq(slopes.reshape(-1, 3), known.ravel(), rcond=None)
    # a hand that the network saw but that covers its pixels from nowhere is put at arm's length
    if not 0.2 < float(place[2]) < 20.0:
        place = 0.5 * ray.mean(axis=0)
    return hand_m + place


def skin_depth(
    depth_m: NDArray[np.float32], pixel_px: Float64, guess_m: Float64, intrinsics: Intrinsics
) -> Float64:
    """Median depth about each landmark's pixel, NaN where there is none, shape (21,), m."""
    result = np.full(len(pixel_px), np.nan)
    height, width = depth_m.shape
    radius = np.maximum(1, np.rint(_PATCH_M * intrinsics.fx_px / guess_m)).astype(int)
    for row, ((u, v), reach) in enumerate(zip(np.rint(pixel_px).astype(int), radius, strict=True)):
        if not (0 <= u < width and 0 <= v < height):
            continue
        patch = depth_m[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
        values = patch[patch > 0.0]  # drops NaN as well
        if values.size >= 3:
            result[row] = float(np.median(values))
    return result


def hidden(pixel_px: Float64, depth_m: Float64, intrinsics: Intrinsics) -> Flags:
    """Which landmarks lie behind a bone of the hand that is not theirs, shape (21,)."""
    begin, end = _BONES[:, 0], _BONES[:, 1]
    along = pixel_px[end] - pixel_px[begin]
    away = pixel_px[:, None] - pixel_px[begin]
    length = np.maximum((along**2).sum(axis=1), 1e-9)
    share = np.clip((away * along).sum(axis=2) / length, 0.0, 1.0)
    apart_px = np.linalg.norm(away - share[..., None] * along, axis=2)
    bone_m = depth_m[begin] + share * (depth_m[end] - depth_m[begin])
    reach_px = _FINGER_M * intrinsics.fx_px / bone_m
    before = (apart_px < reach_px) & (bone_m < depth_m[:, None] - 1.5 * _FINGER_M)
    digit = (np.arange(POINTS) + 3) // 4  # the wrist is digit 0 and no bone's own
    own = (digit[:, None] == digit[end]) & (np.abs(np.arange(POINTS)[:, None] - end) <= 1)
    return np.asarray((before & ~own).any(axis=1), dtype=np.bool_)


def _scale(skin_m: Float64, guess_m: Float64) -> float:
    """By how much the network's hand, and with it its distance, must grow to agree with the depth image.

    NaN where too few landmarks have depth to tell: the hand is a guess then.
    """
    ratio = (skin_m + _SKIN_M) / guess_m
    return float(np.nanmedian(ratio)) if int(np.isfinite(ratio).sum()) >= _FEWEST else float("nan")


def _depths(guess_m: Float64, skin_m: Float64 | None, behind: Flags) -> _Depths:
    guessed = _Depths(guess_m, np.where(behind, _HIDDEN_STD_M, _NETWORK_STD_M))
    if skin_m is None:
        return guessed
    joint_m = skin_m + _SKIN_M
    with np.errstate(invalid="ignore"):
        measured = ~behind & (np.abs(joint_m - guess_m) < _AGREE_M)
    depth = np.where(measured, joint_m, guess_m)
    return _Depths(depth, np.where(measured, _SKIN_STD_M, np.maximum(guessed.std_m, _HIDDEN_STD_M)))


def _facing(direction: Float64) -> Float64:
    """Smallest rotation of the optical axis onto a direction, shape (3, 3)."""
    x, y, z = direction / np.linalg.norm(direction)
    factor = 1.0 / (1.0 + z)
    return np.array(
        [[1.0 - factor * x * x, -factor * x * y, x], [-factor * x * y, 1.0 - factor * y * y, y], [-x, -y, z]]
    )
