"""A report: what was measured in one or more files, before it is drawn or written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from sessions.errors import Refused
from sessions.metrics import Summary
from sessions.reports.passive import measure_beside


@dataclass(frozen=True, slots=True)
class Report:
    """What every rendering starts from.

    Attributes:
        summaries: One per file, in the order in which they were given.
        software_version: Version of the software that measured them.
    """

    summaries: tuple[Summary, ...]
    software_version: str


def build_report(
    paths: Sequence[Path], software_version: str = "", passive: Mapping[Path, Sequence[Path]] | None = None
) -> Report:
    """Measure sealed files.

    Args:
        paths: Takes and therapy sessions, one or more.
        software_version: Version to print; by default that of the installed distribution.
        passive: Passive runs of the same patient and day by path, the likeliest first.

    Raises:
        Refused: No file was named, or one cannot be read or measured.
    """
    if not paths:
        raise Refused("report", "about no file", "about one file or more", "name a take or session")
    runs = passive or {}
    measured = tuple(measure_beside(path, runs.get(path, ())) for path in paths)
    return Report(measured, software_version or installed_version())


def installed_version() -> str:
    """Version of the installed distribution, "unknown" where it runs without being installed."""
    try:
        return version("rehab-app")
    except PackageNotFoundError:
        return "unknown"
