"""Detections in one ``.npz``, of another program or of ours: what was seen when, named in frame 0 only.

Arrays, F frames, D detections, K labels, V cameras (format in docs/cli.md)::

    frame_t_s (F)   u_px v_px (D)   depth_m (D), optional   frame (D), index into frame_t_s
    init_name init_u_px init_v_px (K), optional: markers that a person pointed at in frame 0
    fx fy cx cy width height () or (V)
    similarity pixel_std_px depth_std_m view (D), T_tracking_camera (V, 4, 4), all optional
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rehab_app.geometry.detections import Detections, joined, lifted
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.recording.archive import Archive
from rehab_app.recording.detections_check import (
    check_pixels,
    checked_depth,
    checked_frames,
    checked_labels,
    checked_times,
    column,
)
from rehab_app.recording.detections_noise import Noise, noise_of
from rehab_app.recording.importers.recorded_file import check_readable
from rehab_app.tracking import Labels
from sessions.errors import Refused
from sessions.records.fields import Float64, Int64

NO_DEPTH = (
    "There is no depth: places in space rest on the size of the hand alone, and a curled finger is less sure."
)
_MOST_CAMERAS = 16
_INTRINSICS = ("fx", "fy", "cx", "cy", "width", "height")


@dataclass(frozen=True, slots=True)
class SeenBy:
    """One camera of a file.

    Attributes:
        intrinsics: The pinhole camera.
        view: Where it stands beside the first.
    """

    intrinsics: Intrinsics
    view: View


@dataclass(frozen=True, slots=True)
class DetectionsFile:
    """A file of detections, checked.

    Attributes:
        name: The file's name.
        t_s: Time of each frame, shape (F,).
        frame: Frame of each detection, shape (D,).
        pixel_px: Centres u v, shape (D, 2).
        depth_m: Depth along the optical axis, NaN where there is none, shape (D,).
        similarity: Likeness to a marker, shape (D,).
        noise: Standard deviations of pixels and depths.
        view: Camera of each detection, shape (D,).
        cameras: The cameras.
        labels: Markers named in the first frame, None where there are none.
        complaints: What a person should know of it, one sentence each.
    """

    name: str
    t_s: Float64
    frame: Int64
    pixel_px: Float64
    depth_m: Float64
    similarity: Float64
    noise: Noise
    view: Int64
    cameras: tuple[SeenBy, ...]
    labels: Labels | None
    complaints: tuple[str, ...]

    def captures(self) -> Iterator[tuple[Detections, Int64]]:
        """Frame after frame: what was seen in it, and the row in the file of each detection."""
        order = np.argsort(self.frame, kind="stable")
        edges = np.searchsorted(self.frame[order], np.arange(len(self.t_s) + 1))
        for index, t_ns in enumerate(self.t_ns):
            rows = order[edges[index] : edges[index + 1]]
            rows = rows[np.argsort(self.view[rows], kind="stable")]
            yield self._lifted(int(t_ns), rows), rows

    @property
    def t_ns(self) -> Int64:
        """Time of each frame from the first, ns, shape (F,)."""
        return np.round(1e9 * (self.t_s - self.t_s[0])).astype(np.int64)

    def _lifted(self, t_ns: int, rows: Int64) -> Detections:
        return joined(
            [
                lifted(
                    t_ns,
                    self.pixel_px[mine],
                    self.depth_m[mine],
                    camera.intrinsics,
                    pixel_std_px=self.noise.pixel_std_px[mine],
                    depth_std_m=self.noise.depth_std_m[mine],
                    similarity=self.similarity[mine],
                    view=camera.view,
                )
                for camera in self.cameras
                for mine in (rows[self.view[rows] == camera.view.index],)
            ]
        )


def read_detections(path: Path) -> DetectionsFile:
    """Read and check a file of detections.

    Raises:
        Refused: It is no such file; one sentence names the array, what is wrong and what to do.
    """
    check_readable(path)
    held = Archive(path)
    t_s = checked_times(held)
    frame = checked_frames(held, len(t_s))
    count = len(frame)
    pixel = np.stack([column(held, "u_px", count), column(held, "v_px", count)], axis=1)
    cameras = _cameras(held)
    view = _views(held, count, len(cameras))
    check_pixels(held, pixel, view, tuple(camera.intrinsics for camera in cameras))
    depth = checked_depth(held, count)
    similarity = column(held, "similarity", count) if "similarity" in held else np.ones(count)
    labels = checked_labels(held)
    flat = count > 0 and not np.isfinite(depth).any()
    complaints = (NO_DEPTH,) if flat else ()
    order = np.argsort(frame, kind="stable")
    noise = noise_of(held, t_s, frame, pixel, depth, order)
    return DetectionsFile(
        path.name,
        t_s,
        frame,
        pixel,
        depth,
        np.clip(np.nan_to_num(similarity, nan=1.0), 0.0, 1.0),
        noise,
        view,
        cameras,
        labels,
        complaints,
    )


def _cameras(held: Archive) -> tuple[SeenBy, ...]:
    numbers = [np.atleast_1d(held.numbers(name)).ravel() for name in _INTRINSICS]
    poses = _stated_poses(held)
    count = max(len(poses), *(len(values) for values in numbers))
    thing = f"{held.thing}, {' '.join(_INTRINSICS)}"
    if not 1 <= count <= _MOST_CAMERAS or any(len(values) not in (1, count) for values in numbers):
        sizes = ", ".join(str(len(values)) for values in numbers)
        raise Refused(thing, f"of {sizes} values", "one value each, or one per camera", "mend them")
    table = np.stack([np.broadcast_to(values, count) for values in numbers], axis=1)
    if not bool(np.isfinite(table).all()):
        raise Refused(thing, "not finite", "numbers of px", "calibrate the camera")
    views = _views_of(held, poses, count)
    return tuple(
        SeenBy(_intrinsics(thing, [float(value) for value in row]), view)
        for row, view in zip(table, views, strict=True)
    )


def _intrinsics(thing: str, row: list[float]) -> Intrinsics:
    fx, fy, cx, cy, width, height = row
    if not (1 <= width <= 20_000 and 1 <= height <= 20_000):
        raise Refused(thing, f"an image of {width:g} x {height:g} px", "1 to 20000 px", "give its size")
    camera = Intrinsics(fx, fy, cx, cy, round(width), round(height))
    if not (0 <= cx <= width and 0 <= cy <= height):
        raise Refused(
            thing,
            f"a principal point at {cx:g}, {cy:g} px",
            f"within {width:g} x {height:g} px",
            "give the intrinsics of this resolution",
        )
    return camera


def _stated_poses(held: Archive) -> Float64:
    """``T_tracking_camera`` of each camera, shape (V, ...); none where the file states none."""
    if "T_tracking_camera" not in held:
        return np.zeros((0, 4, 4))
    poses = held.numbers("T_tracking_camera")
    return poses[None] if poses.ndim == 2 else np.atleast_1d(poses)


def _views_of(held: Archive, poses: Float64, count: int) -> tuple[View, ...]:
    if count == 1 and not len(poses):
        return (PRIMARY,)
    thing = f"{held.thing}, T_tracking_camera"
    if poses.shape != (count, 4, 4) or not bool(np.isfinite(poses).all()):
        raise Refused(thing, f"of shape {poses.shape}", f"finite, ({count}, 4, 4)", "calibrate the cameras")
    turn = poses[:, :3, :3]
    error = np.abs(turn @ np.swapaxes(turn, 1, 2) - np.eye(3)).max()
    if error > 1e-3 or bool((np.linalg.det(turn) < 0).any()):
        raise Refused(thing, "no rotation and shift", "a rigid pose", "calibrate the cameras again")
    return tuple(View(index, turn[index], poses[index, :3, 3]) for index in range(count))


def _views(held: Archive, detections: int, cameras: int) -> Int64:
    if "view" not in held:
        if cameras > 1:
            raise Refused(held.thing, f"of {cameras} cameras without view", "with view", "add view (D)")
        return np.zeros(detections, dtype=np.int64)
    view = column(held, "view", detections)
    if view.size and (bool((view != np.round(view)).any()) or view.min() < 0 or view.max() >= cameras):
        raise Refused(
            f"{held.thing}, view", f"{view.max():g}", f"0 to {cameras - 1}", "give the camera of each row"
        )
    return view.astype(np.int64)
