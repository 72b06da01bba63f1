"""Replays of sealed sessions and takes, each in a viser server of its own."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict

import numpy as np

from rehab_app.services.clinic import Clinic
from rehab_app.services.grip_finder import NO_GRIP
from rehab_app.services.grip_target import recorded_choice, way_to_go
from rehab_app.services.rows import Replay
from rehab_app.web.language import _, spoken, written
from rehab_app.web.viewport.aim import Aim
from rehab_app.web.viewport.painter import Painter
from rehab_app.web.viewport.panel import Panel
from rehab_app.web.viewport.scene import furnish
from rehab_app.web.viewport.second import Second
from rehab_app.web.viewport.trails import POINTS
from rehab_app.web.viewport.transport import Transport
from rehab_app.web.viewport.verdict import Verdict, of_error
from rehab_app.web.viewport.words import PHASES

_HZ = 25.0
_TRAIL_S = 2.5
PAIRED = "-"
"""Joins the ids of two recordings that are shown together."""


class ReviewViewport:
    """One replay with time bar, loop and speed.

    Args:
        replay: What to show.
        label: Title of the browser tab.
        second: Another recording to compare it with, None for none.
    """

    def __init__(self, replay: Replay, label: str, second: Replay | None = None) -> None:
        self._replay = replay
        self._end_s = float(replay.t_s[-1])
        self._room = furnish(label, replay.geometry)
        self._room.server.gui.main_panel.dock_right()
        self._transport = Transport(self._room.server, self._end_s, replay.repetitions_s)
        self._second = None if second is None else Second(self._room, second, replay)
        self._panel = Panel(self._room, _("time [s]"), (0.0, self._end_s))
        self._panel.compare(replay.fingertip_error_m is not None)
        self._chart(0.0)
        self._aim = Aim(self._room.server, recorded_choice(replay.prescription))
        self._found = NO_GRIP
        self._drawn_row, self._turn = -1, 0
        self._painted_s = time.monotonic()
        self._painter = Painter(self._room, "review-viewport", self._paint)

    @property
    def port(self) -> int:
        """Port of the viser server on the private loopback address."""
        return self._painter.port

    def close(self) -> None:
        """Stop drawing and close the server."""
        self._painter.close()

    def _paint(self) -> float:
        """Advance by the time since the last picture and draw."""
        now_s = time.monotonic()
        self._transport.advance(now_s - self._painted_s)
        self._painted_s = now_s
        self._draw()
        return 1.0 / _HZ

    def _draw(self) -> None:
        replay, at_s, self._turn = self._replay, self._transport.at_s, self._turn + 1
        row = max(min(int(np.searchsorted(replay.t_s, at_s, side="right")) - 1, replay.t_s.size - 1), 0)
        found, second = self._aim.found(replay.geometry), self._second
        anew = found != self._found or (second is not None and second.changed)
        if row == self._drawn_row and not anew:
            return
        self._drawn_row, self._found = row, found
        reference = replay.reference_joints_rad
        with self._room.server.atomic():
            self._room.draw(
                replay.geometry, replay.patient_joints_rad[row], None if reference is None else reference[row]
            )
            if second is not None:
                second.changed = False
                second.draw(at_s)
            if self._transport.playing:
                self._transport.show(float(replay.t_s[row]))
            if self._turn % 3 == 0 or not self._transport.playing or anew:
                self._beside(row)
                self._chart(at_s)
                target = found.target
                joints = replay.patient_joints_rad[row]
                way = None if target is None else way_to_go(target, joints, worn=replay.worn)
                self._panel.aim(found, way)

    def _chart(self, at_s: float) -> None:
        """The error, with a mark where the picture is, and that of the second recording."""
        error, second = self._replay.fingertip_error_m, self._second
        if error is not None:
            t_s = self._replay.t_s
            self._panel.chart.draw(t_s, 1e3 * error, at_s, None if second is None else second.error_mm(t_s))

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
            detail = _("Guided assessment: nobody is followed.")
            return Verdict("calm", _(PHASES.get(phase, phase)), detail=detail)
        if error is None:
            at = written(float(self._replay.t_s[row]), 1)
            alone = _("The recorded hand alone; there is no reference.")
            return Verdict("calm", _("Take"), at, "s", alone)
        if not np.isfinite(error[row]):
            phase = self._replay.phases[row]
            detail = _("Compared only while the movement is made.")
            return Verdict("calm", _(PHASES.get(phase, phase)), detail=detail)
        return of_error(np.full(5, error[row]), with_worst=False)

    def _facts(self, row: int) -> tuple[tuple[str, str], ...]:
        replay = self._replay
        counted = _("%(n)s of %(m)s")
        times = {"n": written(float(replay.t_s[row]), 1), "m": written(self._end_s, 1)}
        rows = [(_("Time"), f"{counted % times} s")]
        if self._transport.repetitions:
            done = {"n": self._transport.repetition(), "m": self._transport.repetitions}
            rows.append((_("Repetition"), counted % done))
        if self._second is not None:
            error_mm = self._second.error_now_mm(self._transport.at_s)
            known = _("error %(n)s mm") % {"n": written(error_mm, 1)}
            said = known if np.isfinite(error_mm) else _("not compared now")
            rows.append((_("Second recording, green"), said))
        if replay.phases:
            rows.append((_("Phase"), _(PHASES.get(replay.phases[row], replay.phases[row]))))
        past = [
            event
            for event in replay.events
            if event.t_ns * 1e-9 <= replay.t_s[row] and event.severity != "info"
        ]
        if past:
            last = f"{written(past[-1].t_ns * 1e-9, 1)} s: {past[-1].text or past[-1].cause}"
            rows.append((_("Last event"), last))
        return tuple(rows)


class ReviewViewports:
    """The replays that are open, the oldest closed first.

    Args:
        clinic: Its sessions and takes are replayed.
        most: How many stay open.
    """

    def __init__(self, clinic: Clinic, most: int = 4) -> None:
        self._clinic, self._most = clinic, most
        self._open: OrderedDict[tuple[str, str], ReviewViewport] = OrderedDict()
        self._lock = threading.Lock()

    def port_for(self, named: str) -> int:
        """Loopback port that replays a session or take, or two of them joined by ``PAIRED``, opened if not.

        Raises:
            Refused: There is no such recording, or its file is damaged.
        """
        with self._lock:
            key = (named, spoken())  # its panel speaks one language
            if key not in self._open:
                first, _joint, second = named.partition(PAIRED)
                shown = self._clinic.sessions.replay(first)
                beside = self._clinic.sessions.replay(second) if second else None
                self._open[key] = ReviewViewport(shown, _("Review"), beside)
            self._open.move_to_end(key)
            while len(self._open) > self._most:
                self._open.popitem(last=False)[1].close()
            return self._open[key].port

    def close(self) -> None:
        """Close all replays."""
        with self._lock:
            while self._open:
                self._open.popitem()[1].close()
