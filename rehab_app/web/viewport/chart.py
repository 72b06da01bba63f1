"""The error chart: fingertip RMS over time, with the target as a dashed line."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.web.language import _
from rehab_app.web.viewport.verdict import TARGET_MM
from robot_iface.types import Float64

_HEIGHT_PX = 200
_MOST_POINTS = 240
SHORTEST_S = 10.0
_SPAN_MM = 1.6 * TARGET_MM
_HIDDEN: Any = {"show": False}


class ErrorChart:
    """One uPlot chart.

    Args:
        server: The viser server; the chart goes into the current container.
        x_label: Title of the time axis.
        from_s: Where the axis begins; it spans 10 s at least, however short the curve is.
        to_s: Where it ends.
    """

    def __init__(self, server: viser.ViserServer, x_label: str, from_s: float, to_s: float) -> None:
        self._from_s, self._to_s = from_s, max(to_s, from_s + SHORTEST_S)
        self._chart: Any = server.gui.add_uplot(
            _columns(np.array([self._from_s, self._to_s]), np.zeros(2), None),
            (
                {},
                {"label": "error", "stroke": "#00489a", "width": 2, "points": _HIDDEN},
                {"label": "target", "stroke": "#b00020", "width": 1.5, "dash": (7, 5), "points": _HIDDEN},
                {"label": "span", "stroke": "transparent", "points": _HIDDEN},
                {"label": "now", "stroke": "#7d8b96", "width": 1.5, "points": _HIDDEN},
                {"label": "second", "stroke": "#cc5c00", "width": 2, "dash": (3, 4), "points": _HIDDEN},
            ),
            # Without time=False the axis prints dates. The scales are never assigned again: that would
            # drop the ticks of the time axis, so an unseen series keeps zero and the target in sight.
            scales={"x": {"time": False, "range": (self._from_s, self._to_s)}},
            axes=(
                {"label": x_label, "labelSize": 20, "size": 34},
                {"label": _("error [mm RMS]"), "labelSize": 22, "size": 44},
            ),
            legend=_HIDDEN,
            height=_HEIGHT_PX,
            padding=(8, 14, 0, 0),
        )

    def show(self, visible: bool) -> None:
        """Show or hide the chart."""
        self._chart.visible = visible

    def draw(
        self, t_s: Float64, error_mm: Float64, now_s: float | None = None, second_mm: Float64 | None = None
    ) -> None:
        """Replace the curve; what is not finite is left out.

        Args:
            t_s: Times, shape (n,).
            error_mm: Errors, shape (n,).
            now_s: Where a mark stands, None for none.
            second_mm: Errors of a second recording at the same times, shape (n,), None for none.
        """
        known = np.flatnonzero(np.isfinite(error_mm))
        chosen = known[:: max(-(-known.size // _MOST_POINTS), 1)]
        if chosen.size < 2:
            return
        second = None if second_mm is None else second_mm[chosen]
        self._chart.data = _columns(t_s[chosen], error_mm[chosen], now_s, second)


def _columns(
    t_s: Float64, error_mm: Float64, now_s: float | None, second_mm: Float64 | None = None
) -> tuple[Float64, ...]:
    """Time, error, target, the least span to show, the mark, a second curve. A NaN would stop the scaling."""
    mark = np.zeros(t_s.size)
    if now_s is not None:
        mark[int(np.argmin(np.abs(t_s - now_s)))] = max(_SPAN_MM, float(error_mm.max()))
    second = np.zeros(t_s.size) if second_mm is None else np.nan_to_num(second_mm)
    span = np.linspace(0.0, _SPAN_MM, t_s.size)
    return t_s, error_mm, np.full(t_s.size, TARGET_MM), span, mark, second
