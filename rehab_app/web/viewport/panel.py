"""The docked panel at the right: verdict, facts, chart, legend, views. It moves nothing but pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.services.grip_finder import NO_GRIP, FoundGrip
from rehab_app.services.grip_target import WayToGo
from rehab_app.web.language import _
from rehab_app.web.viewport import verdict
from rehab_app.web.viewport.chart import ErrorChart
from rehab_app.web.viewport.goal import goal_html
from rehab_app.web.viewport.scene import VIEW_WORDS, Room, look_from

_WIDTH_PX = 350


class Panel:
    """Widgets that live and review share.

    Args:
        room: What is drawn.
        x_label: Title of the chart's time axis.
        span_s: Where that axis begins and ends.
    """

    def __init__(self, room: Room, x_label: str, span_s: tuple[float, float]) -> None:
        gui = room.server.gui
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_WIDTH_PX)
        self._said: dict[str, str] = {}
        self._card: Any = gui.add_html(verdict.Verdict("calm", _("Ready")).html())
        self._goal: Any = gui.add_html("", visible=False)
        self._facts: Any = gui.add_html("")
        self._mark: Any = gui.add_html("")
        self.camera: Any = gui.add_image(
            np.full((240, 320, 3), 238, dtype=np.uint8), label=_("Camera"), format="jpeg", visible=False
        )
        self.chart = ErrorChart(room.server, x_label, *span_s)
        self._legend: Any = gui.add_html("", visible=False)
        self._comparing, self._target = False, False
        self._add_views(room)
        self._room = room

    def say(self, shown: verdict.Verdict, facts: tuple[tuple[str, str], ...]) -> None:
        """Show a verdict and the facts beneath it; unchanged text costs nothing."""
        self._write("card", self._card, shown.html())
        self._write("facts", self._facts, verdict.lines(facts))

    def aim(self, found: FoundGrip, way: WayToGo | None) -> None:
        """Draw a target grip and say how far the hand is from it. Call inside ``server.atomic()``."""
        target = found.target
        self._room.target.draw(target)
        self._write("goal", self._goal, goal_html(found, way))
        _show(self._goal, found is not NO_GRIP)
        self._explain(self._comparing, target is not None)

    def compare(self, comparing: bool) -> None:
        """Show chart and legend where two hands are compared; else the camera, where there is one."""
        self.chart.show(comparing)
        self._explain(comparing, self._target)

    def _explain(self, comparing: bool, target: bool) -> None:
        """Say which hand is which where there is more than one."""
        self._comparing, self._target = comparing, target
        self._write("legend", self._legend, verdict.legend(comparing=comparing, target=target))
        _show(self._legend, comparing or target)

    def _write(self, name: str, handle: Any, html: str) -> None:
        if self._said.get(name) != html:
            self._said[name] = html
            handle.content = html

    def mark(self, frame: int) -> None:
        """Leave the number of the drawn frame in the page, where the shell looks for a stale picture."""
        self._mark.content = f'<span hidden data-frame="{frame}"></span>'

    def _add_views(self, room: Room) -> None:
        gui = room.server.gui
        named = {_(word): view for view, word in VIEW_WORDS.items()}
        views: Any = gui.add_button_group(_("View"), tuple(named))
        trails: Any = gui.add_checkbox(_("Trails"), True)

        @views.on_click
        def _look(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None and views.value in named:
                look_from(event.client, named[str(views.value)])

        @trails.on_update
        def _trails(_: viser.GuiEvent[Any]) -> None:
            for trail in (room.patient_trail, room.therapist_trail):
                trail.show(bool(trails.value))


def _show(handle: Any, visible: bool) -> None:
    if handle.visible != visible:
        handle.visible = visible
