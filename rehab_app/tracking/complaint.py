"""What keeps a hand from being tracked, in one plain sentence for the person in front of the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.labelling import NONE, Labelling, label_open_hand
from rehab_app.tracking.open_hand import open_shapes
from sessions.records import Side
from sessions.records.fields import Float64

_FIT_M = 0.012
_FEW = 0.4  # share of the markers below which there is no hand to speak of
_LOOSE = 0.35
_MANY = 1.5  # times the markers, from which on a second hand is looked for
_PARTING_ROUNDS = 8
_NAMED = 5


class Complaints:
    """Looks at captures in which no hand of a protocol was found and says why.

    Args:
        protocol: The markers.
        side: Side of the hand.
    """

    def __init__(self, protocol: MarkerProtocol, side: Side) -> None:
        self._protocol = protocol
        self._side: Side = side
        self._other: Side = "left" if side == "right" else "right"
        self._shapes: dict[Side, Float64] = {
            one: open_shapes(MarkerModel(average_subject(protocol, one), protocol))
            for one in (self._side, self._other)
        }

    def searching(self, points_m: Float64, in_view: int = 0) -> str:
        """Why no open hand was found.

        Args:
            points_m: Places of blobs, shape (D, 3).
            in_view: Blobs of the latest capture, where the places are only of those that keep still.
        """
        count = len(self._protocol.names)
        few = max(_FEW * count, 3)
        if len(points_m) < few <= in_view:
            return f"Hold the open hand still for a second: the {in_view} blobs in view are moving."
        if len(points_m) < few:
            return (
                f"No hand with markers is in view: {max(len(points_m), in_view)} of the {count} markers of "
                f"{self._protocol.name} can be seen."
            )
        if len(points_m) >= _MANY * count and self._two(points_m):
            return two_hands()
        ours, theirs = (self._laid(points_m, side) for side in (self._side, self._other))
        if theirs is not None and (ours is None or theirs.residual_m < 0.7 * ours.residual_m):
            return f"This looks like a {self._other} hand; a {self._side} hand was announced."
        if ours is None:
            return (
                f"{len(points_m)} blobs are in view, but no open {self._side} hand with the {count} markers "
                f"of {self._protocol.name}: hold the hand open, its back to the camera."
            )
        missing = [
            name for name, row in zip(self._protocol.names, ours.detection, strict=True) if row == NONE
        ]
        return unseen(missing) if missing else "Hold the open hand still for a second."

    def _laid(self, points_m: Float64, side: Side) -> Labelling | None:
        missing = int(_LOOSE * len(self._protocol.names))
        found = label_open_hand(points_m, self._shapes[side], missing=missing)
        return found if found is not None and found.residual_m < _FIT_M else None

    def _two(self, points_m: Float64) -> bool:
        """Whether the detections fall into two parts that are a hand each."""
        first = _parted(points_m)
        return all(
            any(self._laid(part, side) is not None for side in (self._side, self._other))
            for part in (points_m[first], points_m[~first])
        )


def _parted(points_m: Float64) -> NDArray[np.bool_]:
    """Points in two groups about two middles: which belong to the first, shape (D,)."""
    middle = points_m.mean(axis=0)
    _, _, axes = np.linalg.svd(points_m - middle, full_matrices=False)
    along = (points_m - middle) @ axes[0]
    first = along > 0.0
    for _ in range(_PARTING_ROUNDS):
        if first.all() or not first.any():
            break
        ends = [np.median(points_m[rows], axis=0) for rows in (first, ~first)]
        to_first, to_second = (np.linalg.norm(points_m - end, axis=1) for end in ends)
        first = to_first < to_second
    return first


def unseen(names: list[str]) -> str:
    """That some markers cannot be seen."""
    shown = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    return f"{'These markers are' if len(names) > 1 else 'This marker is'} not seen: {shown}."


def two_hands() -> str:
    """That there is more than one hand."""
    return "Two hands with markers are in view: take one away."
