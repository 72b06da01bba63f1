"""Point sequences with truth: what a detector would hand over of a moving hand, without drawing a picture.

Nine hundred frames take a few seconds. Every seed is another person (bones, axes, places of the markers),
held up another way, doing all exercises of a level in another order. Self-occlusion is by rays against the
skin's capsules; close blobs merge, blobs are missed, shifted and invented, depth has holes and outliers,
frames are lost. In the first second the hand is open and still and every marker is seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.blob_sensor import Blobs, StandingClutter, sense, standing_clutter
from rehab_app.cameras.hiding import open_spots
from rehab_app.cameras.level_scene import level_scene
from rehab_app.cameras.levels import CALM_S, Level, dropped_frames, level_of
from rehab_app.cameras.scene import HandScene, PosedHand, seen_from
from rehab_app.geometry.detections import Detections, joined, lifted
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from sessions.records import Side
from sessions.records.fields import Float64, Int64

STATED_PIXEL_STD_PX = 0.6
STATED_DEPTH_STD_M = 0.002
"""What detections say of themselves: whoever made them does not know the level."""

_FACING = 0.2  # cosine below which a disc is too slanted for a detector
_OPEN_SHARE = 0.5  # of a disc that must be open to be seen

Bool = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class PointSequence:
    """A sequence and its truth. F frames, M markers, V cameras; camera 0 is the tracking camera.

    Attributes:
        level: What it is like.
        protocol: The markers.
        side: Side of the hand.
        intrinsics: Camera of every view.
        views: Where the cameras stand.
        t_ns: Capture times, shape (F,).
        detections: What was found in each frame, in random order; empty where the frame was dropped.
        owner: Per frame: marker that each detection is of, -1 for clutter, shape (D,).
        other: Per frame: second marker of a merged blob, -1 otherwise, shape (D,).
        dropped: Frames that never came, shape (F,).
        pixel_px: True centres in the tracking camera, shape (F, M, 2).
        p_camera_m: True centres in the tracking camera's frame, shape (F, M, 3).
        visible: Whether each marker can be seen by the tracking camera, shape (F, M); a marker that the
            detector missed is visible all the same.
        view_pixel_px: True centres in every camera, shape (V, F, M, 2).
        view_visible: The same as ``visible`` for every camera, shape (V, F, M).
        joints_rad: True joint angles, shape (F, 21).
        landmarks_camera_m: The 25 landmarks, shape (F, 25, 3).
        init_pixel_px: Where a person clicked on each marker in frame 0, shape (M, 2).
    """

    level: Level
    protocol: MarkerProtocol
    side: Side
    intrinsics: Intrinsics
    views: tuple[View, ...]
    t_ns: Int64
    detections: tuple[Detections, ...]
    owner: tuple[Int64, ...]
    other: tuple[Int64, ...]
    dropped: Bool
    pixel_px: Float64
    p_camera_m: Float64
    visible: Bool
    view_pixel_px: Float64
    view_visible: Bool
    joints_rad: Float64
    landmarks_camera_m: Float64
    init_pixel_px: Float64

    def received(self) -> Iterator[tuple[int, Detections]]:
        """Index and detections of the frames that came."""
        for index, detections in enumerate(self.detections):
            if not self.dropped[index]:
                yield index, detections


@dataclass(frozen=True, slots=True)
class _Shot:
    """One camera at one instant: centres (M, 2), what is seen of them (M, 2), depths (M,), visible (M,)."""

    pixel_px: Float64
    seen_px: Float64
    depth_m: Float64
    visible: Bool


def point_sequence(
    level: str | Level,
    seed: int,
    frames: int = 900,
    protocol: str | MarkerProtocol = "thesis25",
    side: Side = "right",
    *,
    exercise: str = "mixed",
    length_m: float | None = None,
    distance_m: float | None = None,
    rate_hz: float = 30.0,
    intrinsics: Intrinsics = KINECT,
    views: tuple[View, ...] = (PRIMARY,),
) -> PointSequence:
    """Detections of a moving hand, and the truth.

    Args:
        level: Name of a level, or a level of one's own.
        seed: Same arguments and seed, same sequence.
        frames: Number of captures, dropped ones included.
        protocol: The markers, or the name of a protocol.
        side: Side of the hand.
        exercise: One of ``exercise_mix.EXERCISES``, or ``mixed`` for all of them.
        length_m: Hand length; drawn if None.
        distance_m: From the tracking camera to the wrist; drawn if None.
        rate_hz: Captures per second.
        intrinsics: Camera of every view.
        views: Where the cameras stand; the first is the tracking camera. All share one clock.

    Raises:
        Refused: Unknown level, protocol or exercise, or a value out of its bound.
    """
    row = level_of(level) if isinstance(level, str) else level
    worn = load_protocol(protocol) if isinstance(protocol, str) else protocol
    scene_rng, sense_rng = (np.random.default_rng([seed, stream]) for stream in (11, 12))
    scene = level_scene(
        row, exercise, frames / rate_hz, worn, side, scene_rng, length_m=length_m, distance_m=distance_m
    )
    return _taken(row, scene, side, np.arange(frames) / rate_hz, intrinsics, views, sense_rng)


def _taken(
    level: Level,
    scene: HandScene,
    side: Side,
    t_s: Float64,
    intrinsics: Intrinsics,
    views: tuple[View, ...],
    rng: np.random.Generator,
) -> PointSequence:
    """The sequence that cameras take of a scene at times (F,)."""
    posed = [scene.at(float(t)) for t in t_s]
    shots = [[_shot(one, view, intrinsics) for one in posed] for view in views]
    dropped = dropped_frames(level, t_s, rng)
    seen = _sensed(level, shots, t_s, intrinsics, rng)
    t_ns = np.rint(t_s * 1e9).astype(np.int64)
    parts = [
        _lifted([blobs[index] for blobs in seen], views, int(t_ns[index]), intrinsics, bool(dropped[index]))
        for index in range(len(t_s))
    ]
    pixel = np.array([[shot.pixel_px for shot in row] for row in shots])
    visible = np.array([[shot.visible for shot in row] for row in shots])
    return PointSequence(
        level=level,
        protocol=scene.worn.protocol,
        side=side,
        intrinsics=intrinsics,
        views=views,
        t_ns=t_ns,
        detections=tuple(part[0] for part in parts),
        owner=tuple(part[1] for part in parts),
        other=tuple(part[2] for part in parts),
        dropped=dropped,
        pixel_px=pixel[0],
        p_camera_m=np.array([one.markers.p_camera_m for one in posed]),
        visible=visible[0],
        view_pixel_px=pixel,
        view_visible=visible,
        joints_rad=np.array([one.joints_rad for one in posed]),
        landmarks_camera_m=np.array([one.landmarks_camera_m for one in posed]),
        init_pixel_px=pixel[0, 0] + rng.normal(0.0, 1.0, pixel[0, 0].shape),
    )


def _shot(posed: PosedHand, view: View, intrinsics: Intrinsics) -> _Shot:
    """What one camera sees of the markers."""
    before = seen_from(posed, view)
    markers = before.markers
    spots, is_open = open_spots(markers, before.skin)
    share = is_open.mean(axis=1)
    pixel = intrinsics.project(markers.p_camera_m)
    size = np.array([intrinsics.width_px - 1.0, intrinsics.height_px - 1.0])
    inside = ((pixel >= 0.0) & (pixel <= size)).all(axis=1)
    visible = (markers.facing() > _FACING) & (share >= _OPEN_SHARE) & inside
    weight = np.where(visible[:, None], is_open, 1.0)
    middle = np.einsum("ms,msi->mi", weight, spots) / weight.sum(axis=1, keepdims=True)
    return _Shot(pixel, intrinsics.project(middle), middle[:, 2], visible)


def _sensed(
    level: Level, shots: list[list[_Shot]], t_s: Float64, intrinsics: Intrinsics, rng: np.random.Generator
) -> list[list[Blobs]]:
    """Blobs of every view and frame."""
    seen: list[list[Blobs]] = []
    for row in shots:
        standing = standing_clutter(level, row[0].pixel_px, float(row[0].depth_m.mean()), intrinsics, rng)
        pairs = zip(row, t_s, strict=True)
        seen.append([_blobs(level, shot, float(t), standing, intrinsics, rng) for shot, t in pairs])
    return seen


def _blobs(
    level: Level,
    shot: _Shot,
    t_s: float,
    standing: StandingClutter,
    intrinsics: Intrinsics,
    rng: np.random.Generator,
) -> Blobs:
    calm = t_s < CALM_S
    return sense(level, shot.seen_px, shot.depth_m, shot.visible, standing, intrinsics, rng, calm=calm)


def _lifted(
    seen: list[Blobs], views: tuple[View, ...], t_ns: int, intrinsics: Intrinsics, dropped: bool
) -> tuple[Detections, Int64, Int64]:
    """Detections of all views of one frame, with their owners."""
    parts: list[Detections] = []
    for blobs, view in zip(seen, views, strict=True):
        count = len(blobs.depth_m)
        parts.append(
            lifted(
                t_ns,
                blobs.pixel_px,
                blobs.depth_m,
                intrinsics,
                pixel_std_px=np.full(count, STATED_PIXEL_STD_PX),
                depth_std_m=np.full(count, STATED_DEPTH_STD_M),
                similarity=np.ones(count),
                view=view,
            )
        )
    owner, other = (np.concatenate(rows) for rows in zip(*((b.owner, b.other) for b in seen), strict=True))
    kept = np.arange(0 if dropped else len(owner), dtype=np.int64)
    return joined(parts).rows(kept), owner[kept], other[kept]
