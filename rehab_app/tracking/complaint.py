"""What keeps a hand from being tracked, in one plain sentence for the person in front of the camera."""

from __future__ import annotations

import numpy as np

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
_MANY = 1.7
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

    def searching(self, points_m: Float64) -> str:
        """Why no open hand was found among detections (D, 3)."""
        count = len(self._protocol.names)
        if len(points_m) < max(_FEW * count, 3):
            return (
                f"No hand with markers is in view: {len(points_m)} of the {count} markers of "
                f"{self._protocol.name} can be seen."
            )
        ours, theirs = (self._laid(points_m, side) for side in (self._side, self._other))
        if theirs is not None and (ours is None or theirs.residual_m < 0.7 * ours.residual_m):
            return f"This looks like a {self._other} hand; a {self._side} hand was announced."
        if ours is None:
            return (
                f"{len(points_m)} blobs are in view, but no open {self._side} hand with the {count} markers "
                f"of {self._protocol.name}: hold the hand open, its back to the camera."
            )
        if self._second(points_m, ours):
            return two_hands()
        missing = [
            name for name, row in zip(self._protocol.names, ours.detection, strict=True) if row == NONE
        ]
        return unseen(missing) if missing else "Hold the open hand still for a second."

    def _laid(self, points_m: Float64, side: Side) -> Labelling | None:
        missing = int(_LOOSE * len(self._protocol.names))
        found = label_open_hand(points_m, self._shapes[side], missing=missing)
        return found if found is not None and found.residual_m < _FIT_M else None

    def _second(self, points_m: Float64, first: Labelling) -> bool:
        """Whether the rest of the detections is a hand as well."""
        rest = np.delete(points_m, first.detection[first.detection != NONE], axis=0)
        if len(points_m) < _MANY * len(self._protocol.names):
            return False
        return any(self._laid(rest, side) is not None for side in (self._side, self._other))


def unseen(names: list[str]) -> str:
    """That some markers cannot be seen."""
    shown = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    return f"{'These markers are' if len(names) > 1 else 'This marker is'} not seen: {shown}."


def two_hands() -> str:
    """That there is more than one hand."""
    return "Two hands with markers are in view: take one away."
