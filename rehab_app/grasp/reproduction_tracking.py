"""Chapter 4 of the thesis: markers tracked before one camera, some of which disappear."""

from __future__ import annotations

import numpy as np

from rehab_app.cameras.sequence import PointSequence, point_sequence
from rehab_app.grasp.reproduction import Line, Part
from rehab_app.tracking.choice import TrackerName, make_tracker
from rehab_app.tracking.tracked import Labels
from sessions.records.fields import Int64

_SEED = 46
_FRAMES = 75
_GONE: tuple[tuple[int, int, tuple[str, ...]], ...] = (
    (20, 49, ("middle_mcp",)),
    (20, 54, ("index_dip", "index_tip")),
    (49, 54, ("middle_pip", "middle_dip", "middle_tip")),
)
"""Figure 4.6: from which frame to which (counted from 0) which markers are gone."""
_LOOKED_AT = (0, 20, 49, 54, 74)


def chapter_4() -> tuple[Part, ...]:
    """Table 4.1, Figures 4.1 to 4.6."""
    return (
        Part(
            "Figures 4.1 to 4.4: sensor, protocol, camera model, blobs",
            "The Kinect is one camera of several (`docs/cameras.md`), virtual unless one is plugged in; "
            "the protocol of Figure 4.2 is "
            "`thesis25`; the pinhole model of Figure 4.3 is calibrated by `rehab-app calibrate`; blobs "
            "are found by the "
            "thesis's colour histogram or by contrast (`docs/detection.md`). Its pictures are not "
            "published.",
        ),
        Part(
            "Table 4.1, Figure 4.5: the tracker",
            "The algorithm is `rehab-app track --tracker rbmcda-literal`, a repaired one `rbmcda`, and "
            "the default `kinematic`, which knows that "
            "the markers sit on a hand. The thesis gives no error or identity figures: ours are in "
            "`docs/benchmarks.md`.",
        ),
        Part(
            "Figure 4.6: markers that disappear and come back",
            "A sequence of ours (virtual camera, level medium, 25 markers, other clutter besides) in "
            "which the markers of the figure are "
            "taken away in the frames that it states, each tracker given the names in frame 1. How many "
            "of the markers that "
            "are there carry their own name:",
            _figure_4_6(),
        ),
    )


def _figure_4_6() -> tuple[Line, ...]:
    sequence = point_sequence("medium", _SEED, _FRAMES)
    trackers: tuple[TrackerName, ...] = ("rbmcda-literal", "kinematic")
    right = {name: _named_rightly(sequence, name) for name in trackers}
    lines: list[Line] = []
    for row, frame in enumerate(_LOOKED_AT):
        ours = ", ".join(f"{name} {right[name][row]}" for name in trackers)
        what = f"frame {frame + 1}"
        lines.append(
            Line(what, "all, by the picture", ours, "frame 75 is not in the figure" if row == 4 else "")
        )
    return tuple(lines)


def _gone_in(frame: int, names: tuple[str, ...]) -> list[int]:
    """Markers that are taken away in a frame."""
    gone = {name for first, end, group in _GONE if first <= frame < end for name in group}
    return [names.index(name) for name in gone]


def _named_rightly(sequence: PointSequence, name: TrackerName) -> list[str]:
    """Markers with their own name of those that are there, in the frames that are looked at."""
    names = sequence.protocol.names
    labels = Labels(names, sequence.init_pixel_px)
    tracker = make_tracker(name, sequence.protocol, sequence.side, labels=labels, seed=_SEED)
    kept: list[Int64] = []
    given: list[Int64] = []
    for frame, detections in sequence.received():
        keep = np.flatnonzero(~np.isin(sequence.owner[frame], _gone_in(frame, names)))
        kept.append(sequence.owner[frame][keep])
        given.extend(hand.detection for hand in tracker.observe(detections.rows(keep)))
    given.extend(hand.detection for hand in tracker.finish())
    received = [frame for frame, _ in sequence.received()]
    counts: list[str] = []
    for frame in _LOOKED_AT:
        at = received.index(frame) if frame in received else int(np.searchsorted(received, frame))
        owner, detection = kept[at], given[at]
        there = [marker for marker in range(len(names)) if marker in owner]
        right = sum(detection[m] >= 0 and owner[detection[m]] == m for m in there)
        counts.append(f"{right} of {len(there)}")
    return counts
