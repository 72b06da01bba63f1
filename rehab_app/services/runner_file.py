"""Keeps the session that goes on in one file of the clinic folder, so that a restart finds it again.

The file is private, holds a pseudonym and no free text but the reasons for skipped steps, and is gone when
the session has ended: what stays is in the journal.
"""

from __future__ import annotations

import os
from pathlib import Path

import msgspec

from rehab_app.services.runner_steps import Course

_PRIVATE = 0o600


class CourseFile:
    """The file.

    Args:
        path: Where it is.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Course | None:
        """The session that goes on; None where there is none, or the file cannot be read as one."""
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=Course)
        except (OSError, msgspec.MsgspecError):
            return None

    def write(self, course: Course | None) -> None:
        """Keep it, whole or not at all; None removes the file."""
        if course is None:
            self._path.unlink(missing_ok=True)
            return
        working = self._path.with_name(f".{self._path.name}.part")
        descriptor = os.open(working, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, _PRIVATE)
        with os.fdopen(descriptor, "wb") as file:
            file.write(msgspec.json.encode(course))
        working.replace(self._path)
