"""When a file was recorded, where that is known."""

from __future__ import annotations

from sessions.records import SessionHeader
from sessions.reports.language import _, moment

UNDATED = frozenset(("leap-motion", "mediapipe-landmarks", "c3d", "glove-csv"))
"""Kinds of imported files that do not say when they were recorded: their headers state the import."""


def recorded(header: SessionHeader) -> str:
    """The moment, or that it is not known and when the file was imported."""
    if header.kind == "take" and header.source in UNDATED:
        return _("time not known, imported %(when)s", when=moment(header.utc_start_ns))
    return moment(header.utc_start_ns)
