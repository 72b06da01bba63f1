"""Finds target grips beside whoever draws: asked again and again, it answers at once with what it knows."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass

from rehab_app.errors import REFUSALS
from rehab_app.services.grip_target import GripChoice, GripTarget, make_target
from robot_iface.kinematics import HandGeometry

_KEPT = 32
_Key = tuple[GripChoice, str, bytes, bytes]


@dataclass(frozen=True, slots=True)
class FoundGrip:
    """What is known of a target grip.

    Attributes:
        target: The target; None while it is being worked out, where there is none, or where none was chosen.
        words: What was chosen, or why there is no target; "" where none was chosen.
        refused: Whether the hand cannot hold the object so.
    """

    target: GripTarget | None = None
    words: str = ""
    refused: bool = False


NO_GRIP = FoundGrip()
_FAILED = FoundGrip(words="The target grip could not be worked out; the server's log says why.", refused=True)


class GripFinder:
    """Works out one target at a time, on a thread of its own, and remembers the last ones."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: OrderedDict[_Key, FoundGrip] = OrderedDict()
        self._working = False

    def find(self, choice: GripChoice | None, geometry: HandGeometry) -> FoundGrip:
        """What is known now; never waits. Ask again while ``target`` is None and it was not refused.

        Args:
            choice: What was chosen, None for nothing.
            geometry: The hand.
        """
        if choice is None:
            return NO_GRIP
        key = (choice, geometry.side, geometry.bones_m.tobytes(), geometry.bases_m.tobytes())
        with self._lock:
            known = self._known.get(key)
            if known is not None:
                self._known.move_to_end(key)
                return known
            if not self._working:
                self._working = True
                threading.Thread(
                    target=self._work, args=(key, choice, geometry), name="grip-finder", daemon=True
                ).start()
        return FoundGrip(words=f"{choice.words}: working it out …")

    def _work(self, key: _Key, choice: GripChoice, geometry: HandGeometry) -> None:
        found = _FAILED
        try:
            found = FoundGrip(make_target(choice, geometry), choice.words)
        except REFUSALS as refusal:
            found = FoundGrip(words=str(refusal), refused=True)
        finally:
            with self._lock:
                self._known[key] = found
                self._working = False
                while len(self._known) > _KEPT:
                    self._known.popitem(last=False)
