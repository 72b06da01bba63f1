"""Pictures of a board: from files, a folder, a pattern, a video, or the frames of an open camera."""

from __future__ import annotations

import glob
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.board import Board
from rehab_app.calibration.corners import Corners, Grey, Rejected, find_board, other_board
from rehab_app.cameras.frame import Capture, Frame
from rehab_app.cameras.video import VideoCamera
from rehab_app.errors import Refused

IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")
VIDEOS = (".mp4", ".avi", ".mkv", ".mov", ".webm", ".m4v")
_MOST_FRAMES = 120
"""Frames of a video that are looked at, spread over its length."""
_EVERY_NS = 400_000_000  # between looks at a live camera: the board has moved by then


@dataclass(frozen=True, slots=True)
class Picture:
    """One grey picture.

    Attributes:
        name: File name, or the number of the frame.
        grey: Image, shape (H, W).
    """

    name: str
    grey: Grey


def pictures(sources: Sequence[str]) -> Iterator[Picture | Rejected]:
    """The pictures that a person names, in natural order (2 before 10).

    Args:
        sources: Image files, folders, patterns such as ``left*.jpg``, or video files.

    Raises:
        Refused: A source is not there, holds no picture, or is no picture by its name.
    """
    for path in files_named(sources):
        if path.suffix.lower() in VIDEOS:
            yield from _of_video(path)
        else:
            yield _of_file(path)


def files_named(sources: Sequence[str]) -> list[Path]:
    """The files behind names, folders and patterns.

    Raises:
        Refused: As ``pictures``.
    """
    found: list[Path] = []
    for source in sources:
        path = Path(source)
        if path.is_dir():
            inside = [item for item in path.iterdir() if item.suffix.lower() in IMAGES]
        elif path.is_file():
            inside = [path]
        else:
            inside = [Path(name) for name in glob.glob(source)]
        if not inside:
            raise Refused(
                f"source {source}",
                "without pictures" if path.is_dir() else "not there",
                "an image, a folder or pattern of images, or a video",
                "check the path",
            )
        found += sorted(inside, key=lambda item: natural(item.name))
    for path in found:
        if path.suffix.lower() not in (*IMAGES, *VIDEOS):
            raise Refused(
                f"source {path.name}",
                f"a file ending in {path.suffix or 'nothing'}",
                "an image (" + " ".join(IMAGES) + ") or a video (" + " ".join(VIDEOS) + ")",
                "name other files",
            )
    return found


def pictures_of(captures: Iterable[Capture], seconds: float) -> Iterator[Picture]:
    """Grey pictures from an open camera, a few each second, for a while.

    Args:
        captures: What the camera gives.
        seconds: How long to look, by the captures' own time.
    """
    first_ns = next_ns = None
    for number, capture in enumerate(captures):
        now_ns = capture.t_capture_ns if isinstance(capture, Frame) else capture.t_ns
        first_ns = now_ns if first_ns is None else first_ns
        if now_ns - first_ns > seconds * 1e9:
            return
        if isinstance(capture, Frame) and (next_ns is None or now_ns >= next_ns):
            next_ns = now_ns + _EVERY_NS
            yield Picture(f"frame {number}", _grey(capture.colour_bgr))


def look_for(
    board: Board, seen: Iterable[Picture | Rejected], told: Callable[[int, int | None], None] | None = None
) -> list[Corners | Rejected]:
    """The board in every picture, or the reason why not.

    Args:
        board: The board.
        seen: The pictures.
        told: Called with the number of pictures done, and None as their total is not known.
    """
    results: list[Corners | Rejected] = []
    first: Picture | None = None
    for item in seen:
        results.append(find_board(item.grey, board, item.name) if isinstance(item, Picture) else item)
        first = item if first is None and isinstance(item, Picture) else first
        if told is not None:
            told(len(results), None)
    if first is None or any(isinstance(item, Corners) for item in results):
        return results
    hint = other_board(first.grey, board)
    return [replace(item, reason=item.reason + hint) for item in results if isinstance(item, Rejected)]


def at_once(seen: Sequence[Sequence[Corners | Rejected]]) -> list[Mapping[int, Corners]]:
    """Pictures of several cameras brought together by instant.

    Pictures belong together that end in the same number (left03.jpg and right03.jpg); where that does not
    name every picture, those at the same place in the order.

    Args:
        seen: What was found in the pictures of each camera.

    Returns:
        Of every instant, the corners by camera; instants at which no camera saw the board are left out.

    Raises:
        Refused: The pictures are neither numbered alike nor equally many.
    """
    keyed = [[_last_number(item.source) for item in one] for one in seen]
    numbered = all(None not in keys and len(set(keys)) == len(keys) for keys in keyed)
    if not numbered or len(set.intersection(*[set(keys) for keys in keyed])) < 1:
        counts = [len(one) for one in seen]
        if len(set(counts)) > 1:
            raise Refused(
                "number of pictures of each camera",
                " and ".join(str(count) for count in counts),
                "the same, or names that end in the same numbers",
                "give pictures that the cameras took at the same instants",
            )
        keyed = [list(range(len(one))) for one in seen]
    instants: dict[int, dict[int, Corners]] = {}
    for camera, (one, keys) in enumerate(zip(seen, keyed, strict=True)):
        for item, key in zip(one, keys, strict=True):
            if isinstance(item, Corners) and key is not None:
                instants.setdefault(key, {})[camera] = item
    return [instants[key] for key in sorted(instants)]


def natural(name: str) -> tuple[tuple[int, str], ...]:
    """A key that sorts numbers in names by their value."""
    parts = re.split(r"(\d+)", name.lower())
    return tuple((int(part), "") if part.isdigit() else (-1, part) for part in parts)


def _last_number(name: str) -> int | None:
    found = re.findall(r"\d+", Path(name).stem)
    return int(found[-1]) if found else None


def _of_file(path: Path) -> Picture | Rejected:
    content = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    try:
        image: Any = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE) if content.size else None
    except cv2.error:
        image = None
    if image is None:
        return Rejected(path.name, "cannot be read as an image")
    return Picture(path.name, image)


def _of_video(path: Path) -> Iterator[Picture]:
    video = VideoCamera(path)
    every = max(1, -(-video.frame_count // _MOST_FRAMES))
    with video:
        for number, frame in enumerate(video.frames()):
            if number % every == 0:
                yield Picture(f"{path.name} frame {number}", _grey(frame.colour_bgr))


def _grey(colour_bgr: Any) -> Grey:
    return np.asarray(cv2.cvtColor(colour_bgr, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
