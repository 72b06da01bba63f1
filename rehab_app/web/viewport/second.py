"""A second recording beside or over the first, aligned by time or repetition by repetition."""

from __future__ import annotations

from typing import Any

import numpy as np

from rehab_app.services.rows import Replay
from rehab_app.web.language import _, marked
from rehab_app.web.viewport.drawn_hand import DrawnHand
from rehab_app.web.viewport.palette import SECOND
from rehab_app.web.viewport.scene import Q_WORLD_PALM_WXYZ, Room
from robot_iface.types import Float64

BESIDE_M = (-0.145, -0.09, 0.0)
"""To the left as the first camera sees it."""
PLACES = (marked("Overlaid"), marked("Side by side"))
ALIGNMENTS = (marked("By repetition"), marked("By time"))


class Second:
    """The second recording.

    Args:
        room: Where it is drawn; its widgets go into the room's panel.
        replay: What is drawn.
        first: What it is compared with.
    """

    def __init__(self, room: Room, replay: Replay, first: Replay) -> None:
        self.replay = replay
        self._first = first
        server, gui = room.server, room.server.gui
        self._frame: Any = server.scene.add_frame("/second", show_axes=False, wxyz=Q_WORLD_PALM_WXYZ)
        self._hand = DrawnHand(server, "/second/hand", replay.geometry, SECOND, palm=True)
        # kept, as clicks come on threads that know no language
        self._beside, self._by_time = _(PLACES[1]), _(ALIGNMENTS[1])
        self._place: Any = gui.add_button_group(_("Second"), (_(PLACES[0]), self._beside))
        self._align: Any = gui.add_button_group(_("Align"), (_(ALIGNMENTS[0]), self._by_time))
        self.changed = True

        @self._place.on_click
        def _put(_: Any) -> None:
            beside = str(self._place.value) == self._beside
            self._frame.position = BESIDE_M if beside else (0.0, 0.0, 0.0)

        @self._align.on_click
        def _turn(_: Any) -> None:
            self.changed = True

    def time_s(self, at_s: Float64) -> Float64:
        """Times of the second recording that belong to times of the first, same shape."""
        if str(self._align.value) == self._by_time:
            return at_s
        return aligned(self._first.repetitions_s, self.replay.repetitions_s, at_s)

    def error_mm(self, t_s: Float64) -> Float64 | None:
        """Its error at times of the first, shape (N,); None where it was compared with nobody."""
        error = self.replay.fingertip_error_m
        return None if error is None else 1e3 * error[self._rows(self.time_s(t_s))]

    def draw(self, at_s: float) -> None:
        """Draw it at a time of the first. Call inside ``server.atomic()``."""
        row = int(self._rows(self.time_s(np.array([at_s])))[0])
        joints = self.replay.patient_joints_rad[row]
        known = bool(np.isfinite(joints).all())
        self._hand.show(known)
        if known:
            self._hand.move(joints)

    def error_now_mm(self, at_s: float) -> float:
        """Its error at a time of the first, mm; NaN where it was not compared."""
        error = self.error_mm(np.array([at_s]))
        return float("nan") if error is None else float(error[0])

    def _rows(self, t_s: Float64) -> Any:
        rows = np.searchsorted(self.replay.t_s, t_s, side="right") - 1
        return np.clip(rows, 0, self.replay.t_s.size - 1)


def aligned(first_s: Float64, second_s: Float64, at_s: Float64) -> Float64:
    """Times of a second recording at the same part of the same repetition as times of a first one.

    Between repetitions, and before and after them, time runs on evenly. Where one of them has none, times are
    the same.

    Args:
        first_s: Repetitions of the first, shape (R, 2).
        second_s: Repetitions of the second, shape (Q, 2).
        at_s: Times of the first, shape (N,).
    """
    count = min(len(first_s), len(second_s))
    if count == 0:
        return at_s
    one, other = first_s[:count].ravel(), second_s[:count].ravel()
    before = other[0] - (one[0] - at_s)
    after = other[-1] + (at_s - one[-1])
    middle = np.interp(at_s, one, other)
    return np.where(at_s < one[0], before, np.where(at_s > one[-1], after, middle))
