"""Play, time bar, loop, speed and repetitions of a review."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.web.language import _
from robot_iface.types import Float64

SPEEDS: dict[str, float] = {"0.1×": 0.1, "¼×": 0.25, "½×": 0.5, "1×": 1.0, "2×": 2.0}
_GRACE_S = 0.4
"""So soon after its start, "previous" means the repetition before rather than this one's start."""


class Transport:
    """Where a review stands, and what moves it; its widgets go into the current container.

    Args:
        server: The viser server.
        end_s: Length of the recording.
        repetitions_s: Start and end of every repetition, shape (R, 2).
    """

    def __init__(self, server: viser.ViserServer, end_s: float, repetitions_s: Float64) -> None:
        self.at_s, self.end_s, self.playing = 0.0, end_s, True
        self._repetitions_s = repetitions_s
        self._factor = 1.0
        gui = server.gui
        # kept, as clicks come on threads that know no language
        self._pause, self._play, self._on = _("Pause"), _("Play"), _("Next ›")
        self._button: Any = gui.add_button(self._pause, icon=viser.Icon.PLAYER_PAUSE)
        self._bar: Any = gui.add_slider(_("Time [s]"), 0.0, round(max(end_s, 0.1), 2), 0.01, 0.0)
        self._speed: Any = gui.add_button_group(_("Speed"), tuple(SPEEDS))
        some, jumps = len(repetitions_s) > 0, (_("‹ Previous"), self._on)
        self._jump: Any = gui.add_button_group(_("Repetition"), jumps, visible=some)
        self._loop: Any = gui.add_checkbox(_("Loop"), True)
        self._only: Any = gui.add_checkbox(_("Only this repetition"), False, visible=some)
        self._listen()

    def advance(self, by_s: float) -> None:
        """Go on by a time, at the chosen speed, around the loop."""
        if not self.playing:
            return
        low_s, high_s = self._span()
        self.at_s += by_s * self._factor
        if self.at_s < high_s:
            return
        if self._loop.value:
            self.at_s = low_s
        else:
            self.at_s = high_s
            self.play(False)

    def show(self, at_s: float) -> None:
        """Move the bar to what is drawn. Call inside ``server.atomic()``."""
        self._bar.value = round(at_s, 2)

    def repetition(self) -> int:
        """Number of the repetition that is shown, from 1; 0 before the first."""
        return int(np.searchsorted(self._repetitions_s[:, 0], self.at_s + 1e-6, side="right"))

    @property
    def repetitions(self) -> int:
        """How many repetitions there are."""
        return len(self._repetitions_s)

    def seek(self, value: Any) -> None:
        """Go to a time; a client may send anything, whatever the bar's ends are."""
        if isinstance(value, int | float) and np.isfinite(value):
            self.at_s = min(max(float(value), 0.0), self.end_s)
            self.play(False)

    def jump(self, forwards: bool) -> None:
        """Go to the start of the next repetition, or of this one and then of the one before."""
        starts = self._repetitions_s[:, 0]
        if forwards:
            later = starts[starts > self.at_s + 1e-6]
            target = later[0] if later.size else self.at_s
        else:
            earlier = starts[starts < self.at_s - _GRACE_S]
            target = earlier[-1] if earlier.size else 0.0
        self.at_s = float(target)

    def play(self, playing: bool) -> None:
        """Play on, or stand still; at the end, playing begins anew."""
        if playing and self.at_s >= self.end_s:
            self.at_s = 0.0
        self.playing = playing
        self._button.label = self._pause if playing else self._play
        self._button.icon = viser.Icon.PLAYER_PAUSE if playing else viser.Icon.PLAYER_PLAY

    def _span(self) -> tuple[float, float]:
        """What the loop goes around: everything, or the repetition that is shown."""
        number = self.repetition()
        if not (self._only.value and number):
            return 0.0, self.end_s
        low_s, high_s = self._repetitions_s[number - 1]
        return float(low_s), min(float(high_s), self.end_s)

    def _listen(self) -> None:
        @self._button.on_click
        def _toggle(_: viser.GuiEvent[Any]) -> None:
            self.play(not self.playing)

        @self._bar.on_update
        def _moved(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:  # moved by a person, not by the replay itself
                self.seek(self._bar.value)

        @self._speed.on_click
        def _pace(_: viser.GuiEvent[Any]) -> None:
            self._factor = SPEEDS.get(str(self._speed.value), self._factor)

        @self._jump.on_click
        def _leap(_: viser.GuiEvent[Any]) -> None:
            self.jump(str(self._jump.value) == self._on)
