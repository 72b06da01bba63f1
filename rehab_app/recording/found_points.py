"""The markers that were found in the pictures of a recording, as arrays that ``track`` reads again."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections
from sessions.records.fields import Int64


class FoundPoints:
    """Collects detections and numbers them from 0."""

    def __init__(self) -> None:
        self._count = 0
        self._frames: list[int] = []
        self._parts: list[Detections] = []

    def add(self, frame: int, detections: Detections) -> Int64:
        """Number of each detection of a frame, shape (D,)."""
        first = self._count
        self._count += len(detections)
        self._frames.append(frame)
        self._parts.append(detections)
        return np.arange(first, self._count, dtype=np.int64)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """What was found: frame, camera, pixel, place and likeness of each detection."""
        if not self._parts:
            return {}
        counts = [len(part) for part in self._parts]
        pixel = np.concatenate([part.pixel_px for part in self._parts])
        return {
            "found_frame": np.repeat(np.array(self._frames, dtype=np.int64), counts),
            "found_view": np.concatenate([part.view for part in self._parts]),
            "found_u_px": pixel[:, 0],
            "found_v_px": pixel[:, 1],
            "found_p_camera_m": np.concatenate([part.p_camera_m for part in self._parts]),
            "found_similarity": np.concatenate([part.similarity for part in self._parts]),
        }
