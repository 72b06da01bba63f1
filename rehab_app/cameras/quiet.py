"""OpenCV without words of its own: what it cannot open is told of in one sentence of ours."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

import cv2


@contextmanager
def quietly() -> Generator[None]:
    """Keep OpenCV from writing to stderr meanwhile."""
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(level)
