"""What the arrays of a file of detections must be; every refusal names the array, the row and the remedy."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.recording.archive import Archive
from rehab_app.recording.importers.recorded_file import MOST_FRAMES
from rehab_app.tracking import Labels
from sessions.errors import Refused
from sessions.records.fields import Float64, Int64

_MOST_DETECTIONS = 5_000_000
_MOST_PER_FRAME = 1000
_FARTHEST_M = 20.0
_OUTSIDE_PX = 8.0
_OUTSIDE_SHARE = 0.01


def column(held: Archive, name: str, count: int) -> Float64:
    """One number per detection, finite unless it may be missing.

    Raises:
        Refused: The array is missing, or its length is not that of ``frame``.
    """
    return _counted(held, name, held.numbers(name), count, "frame")


def _counted(held: Archive, name: str, values: Float64, count: int, like: str) -> Float64:
    """An array, refused if it has not as many numbers as ``like``."""
    if values.shape != (count,):
        raise Refused(
            f"{held.thing}, {name}",
            f"of shape {values.shape}",
            f"({count},), as {like}",
            "give one each",
        )
    return values


def checked_times(held: Archive) -> Float64:
    """Times of the frames, finite and rising.

    Raises:
        Refused: They are not.
    """
    thing = f"{held.thing}, frame_t_s"
    t_s = held.numbers("frame_t_s")
    if t_s.ndim != 1 or not 1 <= t_s.size <= MOST_FRAMES:
        raise Refused(thing, f"of shape {t_s.shape}", f"1 to {MOST_FRAMES} times", "give one per frame")
    if not bool(np.isfinite(t_s).all()):
        raise Refused(thing, "not finite", "times in s", "mend the times")
    back = np.flatnonzero(np.diff(t_s) < 1e-6)
    if back.size:
        row = int(back[0])
        raise Refused(
            thing,
            f"{t_s[row]:g} s then {t_s[row + 1]:g} s at frames {row} and {row + 1}",
            "rising",
            "sort the frames by time and keep one of each",
        )
    if t_s[-1] - t_s[0] > 86_400.0:
        raise Refused(thing, f"spanning {t_s[-1] - t_s[0]:g} s", "at most a day", "give times in s")
    return t_s


def checked_frames(held: Archive, frames: int) -> Int64:
    """Frame of each detection.

    Raises:
        Refused: One is no index into ``frame_t_s``, or there are too many.
    """
    thing = f"{held.thing}, frame"
    frame = held.numbers("frame")
    if frame.ndim != 1 or frame.size > _MOST_DETECTIONS:
        raise Refused(thing, f"of shape {frame.shape}", f"(D,), at most {_MOST_DETECTIONS}", "mend it")
    wrong = np.flatnonzero(~((frame >= 0) & (frame < frames) & (frame == np.round(frame))))
    if wrong.size:
        row = int(wrong[0])
        raise Refused(
            thing,
            f"{frame[row]:g} in row {row}",
            f"a whole number from 0 to {frames - 1}",
            "give the index into frame_t_s",
        )
    if not frame.size:
        raise Refused(held.thing, "without any detection", "markers seen in some frame", "check the detector")
    most = int(np.bincount(frame.astype(np.int64)).max())
    if most > _MOST_PER_FRAME:
        raise Refused(thing, f"{most} detections in one frame", f"at most {_MOST_PER_FRAME}", "filter them")
    return frame.astype(np.int64)


def check_pixels(held: Archive, pixel_px: Float64, view: Int64, cameras: tuple[Intrinsics, ...]) -> None:
    """Refuse pixels that are none, or that no image of the stated size can hold.

    Raises:
        Refused: A pixel is not finite, or more than one in a hundred lies well outside its image.
    """
    wrong = np.flatnonzero(~np.isfinite(pixel_px).all(axis=1))
    if wrong.size:
        raise Refused(
            f"{held.thing}, u_px v_px", f"not finite in row {int(wrong[0])}", "pixels", "leave such rows out"
        )
    size = np.array([(camera.width_px, camera.height_px) for camera in cameras], dtype=np.float64)[view]
    outside = ((pixel_px < -_OUTSIDE_PX) | (pixel_px > size + _OUTSIDE_PX)).any(axis=1)
    if outside.mean() > _OUTSIDE_SHARE:
        row = int(np.flatnonzero(outside)[0])
        raise Refused(
            f"{held.thing}, u_px v_px",
            f"{pixel_px[row, 0]:g}, {pixel_px[row, 1]:g} px in row {row}",
            f"within {size[row, 0]:g} x {size[row, 1]:g} px, as width and height say",
            "give the intrinsics of this resolution",
        )


def checked_depth(held: Archive, count: int) -> Float64:
    """Depths, NaN where there is none (0 says the same, as sensors do); all NaN where the array is missing.

    Raises:
        Refused: A depth is negative or infinite, or they are not in m.
    """
    if "depth_m" not in held:
        return np.full(count, np.nan)
    thing = f"{held.thing}, depth_m"
    depth = column(held, "depth_m", count)
    wrong = np.flatnonzero((depth < 0) | np.isinf(depth))
    if wrong.size:
        row = int(wrong[0])
        raise Refused(thing, f"{depth[row]:g} m in row {row}", "above 0 m, or NaN for none", "mend it")
    depth = np.where(depth > 0, depth, np.nan)
    known = depth[np.isfinite(depth)]
    if known.size and float(np.median(known)) > _FARTHEST_M:
        raise Refused(
            thing, f"{np.median(known):g} m in the middle", f"up to {_FARTHEST_M:g} m", "give depths in m"
        )
    return np.where(depth <= _FARTHEST_M, depth, np.nan)


def checked_labels(held: Archive) -> Labels | None:
    """Markers named in the first frame, None where there are none; a NaN pixel names nothing.

    Raises:
        Refused: The three arrays are not all there, of one length, or name a marker twice.
    """
    parts = ("init_name", "init_u_px", "init_v_px")
    if not any(part in held for part in parts):
        return None
    names = held.texts("init_name")
    values = [np.atleast_1d(held.numbers(part)) for part in parts[1:]]
    pixel = np.stack(
        [
            _counted(held, part, one, len(names), "init_name")
            for part, one in zip(parts[1:], values, strict=True)
        ],
        axis=1,
    )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise Refused(f"{held.thing}, init_name", f"naming {twice[0]} twice", "each marker once", "mend it")
    known = np.flatnonzero(np.isfinite(pixel).all(axis=1))
    if not known.size:
        return None
    return Labels(tuple(names[index] for index in known), pixel[known])
