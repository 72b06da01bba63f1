"""Draws the live desk's snapshots for every browser that looks."""

from __future__ import annotations

import time

import cv2
import numpy as np

from rehab_app.services.clinic import Clinic
from rehab_app.services.live_board import HISTORY_S
from rehab_app.services.live_target import way_of
from rehab_app.services.snapshot import ALONG, BUSY, LiveSnapshot
from rehab_app.web.language import _
from rehab_app.web.viewport import verdict
from rehab_app.web.viewport.painter import Painter
from rehab_app.web.viewport.panel import Panel
from rehab_app.web.viewport.scene import furnish
from rehab_app.web.viewport.words import facts_of, verdict_of

_BUSY_HZ, _IDLE_HZ = 30.0, 5.0
_SLOW_EVERY = 3
STALE_S = 0.3
_MOVING = ("recording", "playing")


class LiveViewport:
    """The live picture: one viser server on loopback, one drawing thread.

    Args:
        clinic: Its live desk is drawn.
    """

    def __init__(self, clinic: Clinic) -> None:
        self._desk = clinic.live
        snapshot = self._desk.snapshot()
        self._room = furnish("Live", snapshot.geometry)
        self._panel = Panel(self._room, _("seconds before now"), (-HISTORY_S, 0.0))
        self._frame, self._fresh_s, self._seen = -1, time.monotonic(), False
        self._state: str = ""
        self._turn = 0
        self._painter = Painter(self._room, "live-viewport", self._paint)

    @property
    def port(self) -> int:
        """Port of the viser server on the private loopback address."""
        return self._painter.port

    def close(self) -> None:
        """Stop drawing and close the server."""
        self._painter.close()

    def _paint(self) -> float:
        """Draw the newest snapshot."""
        snapshot = self._desk.snapshot()
        self._draw(snapshot)
        return 1.0 / (_BUSY_HZ if snapshot.state in BUSY else _IDLE_HZ)

    def _draw(self, snapshot: LiveSnapshot) -> None:
        self._turn += 1
        changed = snapshot.state != self._state
        slow = changed or self._turn % _SLOW_EVERY == 0
        with self._room.server.atomic():
            if changed:
                self._enter(snapshot)
            if snapshot.frame != self._frame or changed:
                self._seen = self._seen or not changed
                self._frame, self._fresh_s = snapshot.frame, time.monotonic()
                self._hands(snapshot, slow=slow)
            if slow:
                self._beside(snapshot)
        if changed:
            self._room.server.flush()

    def _enter(self, snapshot: LiveSnapshot) -> None:
        """A new state begins."""
        if snapshot.state in ("countdown", "rehearsing"):
            self._room.patient_trail.clear()
            self._room.therapist_trail.clear()
        self._panel.camera.visible = snapshot.state in ("countdown", "recording", "processing")
        self._panel.compare(
            snapshot.state in ("rehearsing", "playing", "stopped", "done") and snapshot.kind in ALONG
        )
        self._state, self._seen = snapshot.state, False

    def _hands(self, snapshot: LiveSnapshot, *, slow: bool) -> None:
        patient, therapist = snapshot.patient_joints_rad, snapshot.therapist_joints_rad
        if patient is None and therapist is None:
            patient = np.zeros(21)
        elif patient is None:
            patient, therapist = therapist, None  # while recording, the one hand that is seen is solid
        self._room.draw(snapshot.geometry, patient, therapist)
        if slow and snapshot.state in BUSY:
            for joints, trail in (
                (patient, self._room.patient_trail),
                (therapist, self._room.therapist_trail),
            ):
                if joints is not None and bool(np.isfinite(joints).all()):
                    trail.add(snapshot.geometry, joints)

    def _beside(self, snapshot: LiveSnapshot) -> None:
        """Panel, chart and camera image."""
        stale = self._seen and snapshot.state in _MOVING and time.monotonic() - self._fresh_s > STALE_S
        shown = verdict.Verdict("alarm", _("STALE: this picture is old")) if stale else verdict_of(snapshot)
        self._panel.say(shown, facts_of(snapshot))
        self._panel.aim(snapshot.grip, way_of(snapshot))
        self._panel.mark(snapshot.frame)
        if snapshot.state in BUSY:
            t_s, error_mm = self._desk.error_history()
            self._panel.chart.draw(t_s - max(snapshot.t_s, t_s[-1] if t_s.size else 0.0), error_mm)
        jpeg = self._desk.camera_jpeg() if self._panel.camera.visible else None
        if jpeg is not None:
            image = cv2.imdecode(np.frombuffer(jpeg, dtype=np.uint8), cv2.IMREAD_COLOR)
            if image is not None:
                self._panel.camera.image = np.ascontiguousarray(cv2.resize(image, (320, 240))[:, :, ::-1])
