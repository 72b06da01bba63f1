"""The error chart: fingertip RMS over time, with the target as a dashed line."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.web.viewport.verdict import TARGET_MM
from robot_iface.types import Float64

_HEIGHT_PX = 200
_MOST_POINTS = 400
_SPAN_MM = 1.6 * TARGET_MM
_HIDDEN: Any = {"show": False}


class ErrorChart:
    """One uPlot chart.

    Args:
        server: The viser server; the chart goes into the current container.
        x_label: Title of the time axis.
    """

    def __init__(self, server: viser.ViserServer, x_label: str) -> None:
        self._chart: Any = server.gui.add_uplot(
            _columns(np.array([0.0, 10.0]), np.zeros(2)),
            (
                {},
                {"label": "error", "stroke": "#00489a", "width": 2, "points": _HIDDEN},
                {"label": "target", "stroke": "#b00020", "width": 1.5, "dash": (7, 5), "points": _HIDDEN},
                {"label": "span", "stroke": "transparent", "points": _HIDDEN},
            ),
            # Without time=False the axis prints dates. The scales are never assigned again: that would
            # drop the ticks of the time axis, so an unseen series keeps zero and the target in sight.
            scales={"x": {"time": False}},
            axes=(
                {"label": x_label, "labelSize": 20, "size": 34},
                {"label": "error [mm RMS]", "labelSize": 22, "size": 44},
            ),
            legend=_HIDDEN,
            height=_HEIGHT_PX,
            padding=(8, 14, 0, 0),
        )

    def show(self, visible: bool) -> None:
        """Show or hide the chart."""
        self._chart.visible = visible

    def draw(self, t_s: Float64, error_mm: Float64) -> None:
        """Replace the curve: times (n,) and errors (n,); what is not finite is left out."""
        known = np.flatnonzero(np.isfinite(error_mm))
        chosen = known[:: max(-(-known.size // _MOST_POINTS), 1)]
        if chosen.size >= 2:
            self._chart.data = _columns(t_s[chosen], error_mm[chosen])


def _columns(t_s: Float64, error_mm: Float64) -> tuple[Float64, ...]:
    """Time, error, target and the least span to show. A NaN would stop the scaling."""
    return t_s, error_mm, np.full(t_s.size, TARGET_MM), np.linspace(0.0, _SPAN_MM, t_s.size)
