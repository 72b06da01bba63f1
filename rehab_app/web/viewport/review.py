"""Replays of sealed sessions and takes, each in a viser server of its own."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from typing import Any

import numpy as np
import viser

from rehab_app.services.clinic import Clinic
from rehab_app.services.grip_finder import NO_GRIP
from rehab_app.services.grip_target import way_to_go
from rehab_app.services.rows import Replay
from rehab_app.web.viewport.aim import Aim
from rehab_app.web.viewport.painter import Painter
from rehab_app.web.viewport.panel import Panel
from rehab_app.web.viewport.scene import furnish
from rehab_app.web.viewport.trails import POINTS
from rehab_app.web.viewport.verdict import Verdict, of_error
from rehab_app.web.viewport.words import PHASES

_HZ = 25.0
_TRAIL_S = 2.5
SPEEDS: dict[str, float] = {"¼×": 0.25, "½×": 0.5, "1×": 1.0, "2×": 2.0}


class ReviewViewport:
    """One replay with time bar, loop and speed.

    Args:
        replay: What to show.
        label: Title of the browser tab.
    """

    def __init__(self, replay: Replay, label: str) -> None:
        self._replay = replay
        self._end_s = float(replay.t_s[-1])
        self._room = furnish(label, replay.geometry)
        self._add_transport()
        self._panel = Panel(self._room, "time [s]")
        self._panel.compare(replay.fingertip_error_m is not None)
        if replay.fingertip_error_m is not None:
            self._panel.chart.draw(replay.t_s, 1e3 * replay.fingertip_error_m)
        self._aim, self._found = Aim(self._room.server), NO_GRIP
        self._at_s, self._drawn_row, self._playing, self._turn = 0.0, -1, True, 0
        self._painted_s = time.monotonic()
        self._painter = Painter(self._room, "review-viewport", self._paint)

    @property
    def port(self) -> int:
        """Port of the viser server on the private loopback address."""
        return self._painter.port

    def close(self) -> None:
        """Stop drawing and close the server."""
        self._painter.close()

    def _add_transport(self) -> None:
        gui = self._room.server.gui
        gui.main_panel.dock_right()
        self._button: Any = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE)
        self._bar: Any = gui.add_slider("Time [s]", 0.0, round(max(self._end_s, 0.1), 2), 0.01, 0.0)
        self._speed: Any = gui.add_button_group("Speed", tuple(SPEEDS))
        self._loop: Any = gui.add_checkbox("Loop", True)
        self._factor = 1.0

        @self._button.on_click
        def _toggle(_: viser.GuiEvent[Any]) -> None:
            self._play(not self._playing)

        @self._bar.on_update
        def _moved(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:  # moved by a person, not by the replay itself
                self._seek(self._bar.value)

        @self._speed.on_click
        def _pace(_: viser.GuiEvent[Any]) -> None:
            self._factor = SPEEDS.get(str(self._speed.value), self._factor)

    def _seek(self, value: Any) -> None:
        """Go to a time; a client may send anything, whatever the bar's ends are."""
        if isinstance(value, int | float) and np.isfinite(value):
            self._at_s = min(max(float(value), 0.0), self._end_s)
            self._play(False)

    def _play(self, playing: bool) -> None:
        if playing and self._at_s >= self._end_s:
            self._at_s = 0.0
        self._playing = playing
        self._button.label = "Pause" if playing else "Play"
        self._button.icon = viser.Icon.PLAYER_PAUSE if playing else viser.Icon.PLAYER_PLAY

    def _paint(self) -> float:
        """Advance by the time since the last picture and draw."""
        now_s = time.monotonic()
        if self._playing:
            self._advance((now_s - self._painted_s) * self._factor)
        self._painted_s = now_s
        self._draw()
        return 1.0 / _HZ

    def _advance(self, by_s: float) -> None:
        self._at_s += by_s
        if self._at_s < self._end_s:
            return
        if self._loop.value:
            self._at_s = 0.0
        else:
            self._at_s = self._end_s
            self._play(False)

    def _draw(self) -> None:
        replay, self._turn = self._replay, self._turn + 1
        row = max(min(int(np.searchsorted(replay.t_s, self._at_s, side="right")) - 1, replay.t_s.size - 1), 0)
        found = self._aim.found(replay.geometry)
        if row == self._drawn_row and found == self._found:
            return
        anew = found != self._found
        self._drawn_row, self._found = row, found
        reference = replay.reference_joints_rad
        with self._room.server.atomic():
            self._room.draw(
                replay.geometry, replay.patient_joints_rad[row], None if reference is None else reference[row]
            )
            if self._playing:
                self._bar.value = round(float(replay.t_s[row]), 2)
            if self._turn % 3 == 0 or not self._playing or anew:
                self._beside(row)
                target = found.target
                joints = replay.patient_joints_rad[row]
                self._panel.aim(found, None if target is None else way_to_go(target, joints))

    def _beside(self, row: int) -> None:
        """Trails, card and chart."""
        replay = self._replay
        first = int(np.searchsorted(replay.t_s, replay.t_s[row] - _TRAIL_S))
        past = np.unique(np.linspace(first, row, min(POINTS, row - first + 1)).astype(np.int64))
        self._room.patient_trail.replace(replay.geometry, replay.patient_joints_rad[past])
        if replay.reference_joints_rad is not None:
            self._room.therapist_trail.replace(replay.geometry, replay.reference_joints_rad[past])
        self._panel.say(self._verdict(row), self._facts(row))

    def _verdict(self, row: int) -> Verdict:
        error = self._replay.fingertip_error_m
        if error is None and self._replay.phases:
            phase = self._replay.phases[row]
            return Verdict("calm", PHASES.get(phase, phase), detail="Guided assessment: nobody is followed.")
        if error is None:
            return Verdict(
                "calm",
                "Take",
                f"{self._replay.t_s[row]:.1f}",
                "s",
                "The recorded hand alone; there is no reference.",
            )
        if not np.isfinite(error[row]):
            phase = self._replay.phases[row]
            return Verdict(
                "calm", PHASES.get(phase, phase), detail="Compared only while the movement is made."
            )
        return of_error(np.full(5, error[row]), with_worst=False)

    def _facts(self, row: int) -> tuple[tuple[str, str], ...]:
        replay = self._replay
        rows = [("Time", f"{replay.t_s[row]:.1f} of {self._end_s:.1f} s")]
        if replay.phases:
            rows.append(("Phase", PHASES.get(replay.phases[row], replay.phases[row])))
        past = [
            event
            for event in replay.events
            if event.t_ns * 1e-9 <= replay.t_s[row] and event.severity != "info"
        ]
        if past:
            rows.append(("Last event", f"{past[-1].t_ns * 1e-9:.1f} s: {past[-1].text or past[-1].cause}"))
        return tuple(rows)


class ReviewViewports:
    """The replays that are open, the oldest closed first.

    Args:
        clinic: Its sessions and takes are replayed.
        most: How many stay open.
    """

    def __init__(self, clinic: Clinic, most: int = 4) -> None:
        self._clinic, self._most = clinic, most
        self._open: OrderedDict[str, ReviewViewport] = OrderedDict()
        self._lock = threading.Lock()

    def port_for(self, named: str) -> int:
        """Loopback port that replays a session or take, opened if it is not.

        Raises:
            Refused: There is no such recording, or its file is damaged.
        """
        with self._lock:
            if named not in self._open:
                self._open[named] = ReviewViewport(self._clinic.sessions.replay(named), "Review")
            self._open.move_to_end(named)
            while len(self._open) > self._most:
                self._open.popitem(last=False)[1].close()
            return self._open[named].port

    def close(self) -> None:
        """Close all replays."""
        with self._lock:
            while self._open:
                self._open.popitem()[1].close()
