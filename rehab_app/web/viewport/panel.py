"""The docked panel at the right: verdict, facts, chart, legend, views. It moves nothing but pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.web.viewport import verdict
from rehab_app.web.viewport.chart import ErrorChart
from rehab_app.web.viewport.scene import VIEWS, Room, look_from

_WIDTH_PX = 400


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
        self.camera: Any = gui.add_image(
            np.full((240, 320, 3), 238, dtype=np.uint8), label="Camera", format="jpeg", visible=False
        )
        self.chart = ErrorChart(room.server, x_label)
        self._legend: Any = gui.add_html(verdict.LEGEND)
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

    def compare(self, comparing: bool) -> None:
        """Show chart and legend where two hands are compared; else the camera, where there is one."""
        self.chart.show(comparing)
        self._legend.visible = comparing

    def mark(self, frame: int) -> None:
        """Leave the number of the drawn frame in the page, where the shell looks for a stale picture."""
        self._mark.content = f'<span hidden data-frame="{frame}"></span>'

    def _add_views(self, room: Room) -> None:
        gui = room.server.gui
        views: Any = gui.add_button_group("View", tuple(VIEWS))
        trails: Any = gui.add_checkbox("Trails", True)

        @views.on_click
        def _look(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None and views.value in VIEWS:
                look_from(event.client, str(views.value))

        @trails.on_update
        def _trails(_: viser.GuiEvent[Any]) -> None:
            for trail in (room.patient_trail, room.therapist_trail):
                trail.show(bool(trails.value))
