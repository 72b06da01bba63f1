"""The docked panel at the right: verdict, facts, chart, legend, views. It moves nothing but pictures."""

from __future__ import annotations

from typing import Any

import viser

from rehab_app.web.viewport import verdict
from rehab_app.web.viewport.chart import ErrorChart
from rehab_app.web.viewport.scene import VIEWS, Room, look_from

_WIDTH_PX = 380


class Panel:
    """Widgets that live and review share.

    Args:
        room: What is drawn.
        x_label: Title of the chart's time axis.
    """

    def __init__(self, room: Room, x_label: str) -> None:
        gui = room.server.gui
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_WIDTH_PX)
        self._said: dict[str, str] = {}
        self._card: Any = gui.add_html(verdict.Verdict("calm", "Ready").html())
        self._facts: Any = gui.add_html("")
        self._mark: Any = gui.add_html("")
        self.chart = ErrorChart(room.server, x_label)
        gui.add_html(verdict.LEGEND)
        self._add_views(room)

    def say(self, shown: verdict.Verdict, facts: tuple[tuple[str, str], ...]) -> None:
        """Show a verdict and the facts beneath it; unchanged text costs nothing."""
        for name, handle, html in (
            ("card", self._card, shown.html()),
            ("facts", self._facts, verdict.lines(facts)),
        ):
            if self._said.get(name) != html:
                self._said[name] = html
                handle.content = html

    def mark(self, frame: int) -> None:
        """Leave the number of the drawn frame in the page, where the shell looks for a stale picture."""
        self._mark.content = f'<span hidden data-frame="{frame}"></span>'

    def _add_views(self, room: Room) -> None:
        gui = room.server.gui
        views: Any = gui.add_button_group("View", tuple(VIEWS))
        therapist: Any = gui.add_checkbox("Therapist's trails", True)
        patient: Any = gui.add_checkbox("Patient's trails", True)

        @views.on_click
        def _look(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None and views.value in VIEWS:
                look_from(event.client, str(views.value))

        @therapist.on_update
        def _therapist(_: viser.GuiEvent[Any]) -> None:
            room.therapist_trail.show(bool(therapist.value))

        @patient.on_update
        def _patient(_: viser.GuiEvent[Any]) -> None:
            room.patient_trail.show(bool(patient.value))
