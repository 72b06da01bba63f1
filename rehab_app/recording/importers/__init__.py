"""Recordings of other programs, made into takes."""

from rehab_app.recording.importers.imported import ImportedTake, import_recording

__all__ = ["ImportedTake", "import_recording"]
