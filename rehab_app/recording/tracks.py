"""What became of every marker, frame by frame, as plain arrays in one ``.npz``: the format of docs/cli.md."""

from __future__ import annotations

import os
import uuid
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.tracking import TrackedHand
from rehab_app.tracking.description import unknown
from sessions.errors import Refused
from sessions.records import JOINTS, Status
from sessions.records.fields import Float64, Int64, UInt8

SUFFIX = ".npz"
COAST = 3
"""Captures for which a marker that is no longer detected still counts as seen."""
_NONE = -1


@dataclass(frozen=True, slots=True)
class Tracks:
    """The markers of a whole recording. What is lost is NaN.

    Attributes:
        marker: Names of the M markers.
        t_s: Time of each of the F frames, shape (F,).
        pixel_px: Where each marker is in the first camera's image; estimates too, shape (F, M, 2).
        status: 0 lost, 1 estimated, 2 measured, shape (F, M).
        p_camera_m: Places, estimates too, shape (F, M, 3).
        detection: Row of the detection that each marker was given, -1 for none, shape (F, M).
        joints_rad: Joint angles in the order of JOINTS, shape (F, 21).
        joint_std_rad: Their standard deviations, shape (F, 21).
        joint_status: 0 lost, 1 estimated, 2 measured, shape (F, 21).
    """

    marker: tuple[str, ...]
    t_s: Float64
    pixel_px: Float64
    status: UInt8
    p_camera_m: Float64
    detection: Int64
    joints_rad: Float64
    joint_std_rad: Float64
    joint_status: UInt8

    @property
    def visible(self) -> NDArray[np.bool_]:
        """Whether each marker counts as seen, shape (F, M).

        It does where it was measured, and where a detection of it is missing for at most three captures
        running while it is still estimated: detectors miss a marker now and then that anybody can see.
        ``status`` tells the two apart. Captures in which nothing at all was detected do not count.
        """
        measured = self.status == Status.MEASURED
        at = np.cumsum(measured.any(axis=1))[:, None]
        last = np.maximum.accumulate(np.where(measured, at, -COAST - 1), axis=0)
        return (at - last <= COAST) & (self.status != Status.LOST)


def check_tracks_target(path: Path, option: str = "--out") -> None:
    """Refuse a path that a new file cannot be written to.

    Raises:
        Refused: It exists already, or its folder does not.
    """
    if path.exists():
        raise Refused(option, f"{path.name!r}, which exists", "a new file", "choose another name")
    if not path.parent.is_dir():
        raise Refused(f"folder of {option}", repr(str(path.parent)), "an existing folder", "create it first")


class TrackLog:
    """Collects what becomes of every capture; one of which nothing is understood is a gap.

    Args:
        marker: Names of the markers.
        camera: The first camera, in whose image estimates are placed.
    """

    def __init__(self, marker: tuple[str, ...], camera: Intrinsics) -> None:
        self._marker = marker
        self._camera = camera
        self._waiting: deque[tuple[int, Int64]] = deque()
        self._rows: list[_Row] = []
        self.t_ns: list[int] = []

    def saw(self, t_ns: int, rows: Int64) -> None:
        """A capture was handed to the tracker.

        Args:
            t_ns: Its time, later than those before.
            rows: Row in the input of each of its detections, shape (D,).
        """
        self.t_ns.append(t_ns)
        self._waiting.append((t_ns, rows))

    def understood(self, tracked: tuple[TrackedHand, ...]) -> tuple[TrackedHand, ...]:
        """Captures were understood: the same, with those before them that never will be as gaps."""
        complete: list[TrackedHand] = []
        for one in tracked:
            complete += self._given_up(one.markers.t_ns)
            if self._waiting and self._waiting[0][0] == one.markers.t_ns:
                _, rows = self._waiting.popleft()
                self._rows.append(_row(one, rows, self._camera))
                complete.append(one)
        return tuple(complete)

    def end(self) -> tuple[TrackedHand, ...]:
        """No more captures come: those that still wait, as gaps."""
        return tuple(self._given_up(None))

    def tracks(self, t_s: Float64) -> Tracks:
        """Arrays over all captures.

        Args:
            t_s: Time of each capture as the input states it, shape (F,).
        """
        rows = self._rows
        return Tracks(
            self._marker,
            t_s,
            np.array([row.pixel_px for row in rows]),
            np.array([row.status for row in rows]),
            np.array([row.p_camera_m for row in rows]),
            np.array([row.detection for row in rows]),
            np.array([row.joints_rad for row in rows]),
            np.array([row.joint_std_rad for row in rows]),
            np.array([row.joint_status for row in rows]),
        )

    def _given_up(self, before_ns: int | None) -> list[TrackedHand]:
        """Gaps for the captures that wait, up to a time."""
        gaps: list[TrackedHand] = []
        while self._waiting and (before_ns is None or self._waiting[0][0] < before_ns):
            t_ns, rows = self._waiting.popleft()
            gaps.append(unknown(t_ns, len(self._marker), "searching"))
            self._rows.append(_row(gaps[-1], rows, self._camera))
        return gaps


@dataclass(frozen=True, slots=True)
class _Row:
    """One capture; see ``Tracks``."""

    pixel_px: Float64
    status: UInt8
    p_camera_m: Float64
    detection: Int64
    joints_rad: Float64
    joint_std_rad: Float64
    joint_status: UInt8


def _row(one: TrackedHand, rows: Int64, camera: Intrinsics) -> _Row:
    given = one.detection != _NONE
    detection = np.full(len(given), _NONE, dtype=np.int64)
    detection[given] = rows[one.detection[given]]
    variance = np.diagonal(one.pose.joint_covariance_rad2)
    return _Row(
        marker_pixels(one, camera),
        one.markers.status,
        one.markers.p_camera_m,
        detection,
        one.pose.joints_rad,
        np.sqrt(np.maximum(variance, 0.0)),
        one.pose.joint_status,
    )


def marker_pixels(tracked: TrackedHand, camera: Intrinsics) -> Float64:
    """Where each marker is in the first camera's image, shape (M, 2).

    It is its place in space projected, which rests on more than one capture and may come from another camera;
    where there is no place, the pixel at which it was seen or, by a tracker in the plane, is expected.
    """
    place = tracked.markers.p_camera_m
    ahead = np.isfinite(place).all(axis=1) & (place[:, 2] > 0.01)
    pixel = np.where((tracked.markers.status != Status.LOST)[:, None], tracked.markers.pixel_px, np.nan)
    pixel[ahead] = camera.project(place[ahead])
    return pixel


def write_tracks(path: Path, tracks: Tracks, **more: NDArray[Any]) -> None:
    """Write the arrays; the file is whole or absent.

    Args:
        path: New file.
        tracks: The arrays.
        more: Further arrays that the input led to.

    Raises:
        Refused: A file has meanwhile taken the name.
        OSError: The disk refuses.
    """
    check_tracks_target(path)
    arrays: dict[str, NDArray[Any]] = {**_arrays(tracks), **more}
    working = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}{SUFFIX}")
    try:
        with working.open("xb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)
            file.flush()
            os.fsync(file.fileno())
        check_tracks_target(path)
        working.rename(path)
    finally:
        working.unlink(missing_ok=True)


def _arrays(tracks: Tracks) -> dict[str, NDArray[Any]]:
    """The arrays by the names that the file gives them."""
    return {
        "marker": np.array(tracks.marker),
        "t_s": tracks.t_s,
        "u_px": tracks.pixel_px[..., 0],
        "v_px": tracks.pixel_px[..., 1],
        "visible": tracks.visible,
        "p_camera_m": tracks.p_camera_m,
        "detection": tracks.detection,
        "status": tracks.status,
        "joint": np.array(JOINTS),
        "joints_rad": tracks.joints_rad,
        "joint_std_rad": tracks.joint_std_rad,
        "joint_status": tracks.joint_status,
    }
