"""What is learned from a recording: pure functions per family, a registry, and ``measure``."""

from sessions.metrics.measure import measure
from sessions.metrics.metric import Estimate, Lineage, Metric
from sessions.metrics.opened import measure_file
from sessions.metrics.recording import Recording
from sessions.metrics.registry import DEFINITIONS, Definition, definition
from sessions.metrics.summary import Curves, Overlay, Repetition, Stop, Summary

__all__ = [
    "DEFINITIONS",
    "Curves",
    "Definition",
    "Estimate",
    "Lineage",
    "Metric",
    "Overlay",
    "Recording",
    "Repetition",
    "Stop",
    "Summary",
    "definition",
    "measure",
    "measure_file",
]
