"""Pictures as inline SVG. matplotlib is imported when the first one is drawn, without pyplot's global state.

Patient: blue and solid. Therapist: orange and dashed, as on the clinic's screen. Never colour alone.
"""

from __future__ import annotations

import io
import re
from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from sessions.metrics import Curves, Overlay, Summary
from sessions.records import DIGITS, JOINTS
from sessions.records.fields import Float64
from sessions.reports.language import _, decimal
from sessions.reports.remarks import remark
from sessions.reports.wording import joint_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PATIENT = {"color": "#0072B2", "linestyle": "-", "linewidth": 4.0, "alpha": 0.5}
THERAPIST = {"color": "#C94F00", "linestyle": (0, (4, 2)), "linewidth": 1.6}
ALONE = {"color": "#0072B2", "linestyle": "-", "linewidth": 1.6}
MOVED_M = 0.005
MOVED_SHARE = 0.15
"""A digit or joint is drawn where it moves by at least this share of the one that moves most."""
MOVED_RAD = np.deg2rad(2.0)
MOST_JOINTS = 6
MANY_REPETITIONS = 60
"""More than so many bars are drawn as one outline: nobody tells them apart, and each takes time."""
MARKS = 12
"""About so many repetitions are marked on a line and on the axis below it."""
FEW_DIGITS = 2
"""Up to so many digits leave room for a panel against time beside each path."""
_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "rehab-app",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "axes.edgecolor": "#7b8590",
    "axes.axisbelow": True,
    "legend.frameon": False,
}


@contextmanager
def drawing() -> Generator[None]:
    """The style in which everything here is drawn; it leaves matplotlib's own settings as they were."""
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        yield


@drawing()
def paths_picture(overlay: Overlay, key: str) -> str:
    """Fingertip paths from the thumb's side, one panel per digit that moved, all to the same scale."""
    shown = overlay.reference or overlay.hand
    travel = [_travel(shown, overlay.hand, column) for column in range(len(DIGITS))]
    largest = max(travel)
    least = max(MOVED_M, MOVED_SHARE * largest)
    digits = [column for column in range(len(DIGITS)) if travel[column] >= least]
    if not digits:
        return ""
    figure = new_figure(7.4, 3.0 if len(digits) <= 3 else 2.4)
    beside = len(digits) <= FEW_DIGITS
    panels = _row(figure, 2 * len(digits) if beside else len(digits))
    for place, column in enumerate(digits):
        axes = panels[2 * place if beside else place]
        _path(axes, overlay, column, largest * 1000.0)
        if beside:
            _height(panels[2 * place + 1], overlay, column)
    panels[0].set_ylabel(_("out of the palm (mm)"))
    figure.supxlabel(
        _("paths: towards the fingers (mm)") if beside else _("towards the fingers (mm)"), fontsize=9
    )
    _legend(figure, panels[0])
    return svg(figure, key, _said(_("Fingertip paths seen from the thumb's side"), overlay.shown))


@drawing()
def joints_picture(summary: Summary, key: str) -> str:
    """Angles against time of the joints that moved most."""
    overlay = summary.overlay
    shown = overlay.reference or overlay.hand
    if not len(shown.t_s):
        return ""
    span = _spans(shown.joints_rad)
    chosen = sorted(np.argsort(-span, kind="stable")[:MOST_JOINTS])
    chosen = [
        int(column) for column in chosen if span[column] >= max(MOVED_RAD, MOVED_SHARE * float(span.max()))
    ]
    if not chosen:
        return ""
    rows = (len(chosen) + 2) // 3
    figure = new_figure(7.4, 1.75 * rows + 0.5)
    grid: Any = figure.subplots(rows, 3, sharex=True, squeeze=False)
    for place, axes in enumerate(grid.flat):
        if place >= len(chosen):
            axes.set_visible(False)
            continue
        column = chosen[place]
        for curves, style, label in _lines(overlay):
            axes.plot(curves.t_s, np.rad2deg(curves.joints_rad[:, column]), label=label, **style)
        axes.set_title(joint_name(JOINTS[column]), fontsize=9)
        axes.xaxis.set_tick_params(labelbottom=place >= len(chosen) - 3)
        if place >= len(chosen) - 3:
            axes.set_xlabel(_("time (s)"))
        if place % 3 == 0:
            axes.set_ylabel(_("angle (°)"))
    _legend(figure, grid.flat[0])
    return svg(figure, key, _said(_("Joint angles against time"), overlay.shown))


@drawing()
def repetitions_picture(summary: Summary, key: str) -> str:
    """Joint error and assistance by repetition; empty below two repetitions or without an error."""
    known = [item for item in summary.repetitions if item.rmse_rad == item.rmse_rad]
    if len(known) < 2:
        return ""
    figure = new_figure(7.4, 2.3)
    left, right = _row(figure, 2)
    number = [item.index + 1 for item in known]
    _bars(left, number, [float(np.rad2deg(item.rmse_rad)) for item in known])
    left.set_ylabel(_("joint error (° RMS)"))
    helped = np.array([item.assistance for item in known])
    for column in range(len(DIGITS)):
        if np.isfinite(helped[:, column]).any():
            marker = "osD^v"[column]
            right.plot(
                number,
                helped[:, column],
                marker=marker,
                markevery=max(1, len(number) // MARKS),
                label=joint_name(DIGITS[column]),
                linewidth=1.4,
                markersize=5,
            )
    right.set_ylabel(_("assistance (× thesis gains)"))
    right.set_ylim(bottom=0.0)
    for axes in (left, right):
        axes.set_xlabel(_("repetition"))
        axes.set_xticks(number if len(number) <= MARKS else number[:: max(1, len(number) // 10)])
    if right.lines:
        right.legend(loc="best", fontsize=8, ncols=2)
    return svg(figure, key, _said(_("Joint error and assistance by repetition"), summary.conditions))


def _bars(axes: Axes, number: list[int], height: list[float]) -> None:
    """A bar per repetition; of many, the outline of bars that touch."""
    if len(number) <= MANY_REPETITIONS:
        axes.bar(number, height, 0.6, color=PATIENT["color"])
        return
    edges = np.repeat(number, 2) + np.tile((-0.5, 0.5), len(number))
    axes.fill_between(edges, np.repeat(height, 2), color=PATIENT["color"], linewidth=0.0)
    axes.set_ylim(bottom=0.0)


def _path(axes: Axes, overlay: Overlay, column: int, extent_mm: float) -> None:
    """One fingertip's path from the side, the therapist's dashes over the patient's line."""
    for curves, style, label in _lines(overlay):
        tip_mm = curves.fingertips_palm_m[:, column] * 1000.0
        axes.plot(tip_mm[:, 2], tip_mm[:, 0], label=label, **style)
    _same_scale(axes, overlay, column, extent_mm)
    axes.set_title(_("%(digit)s: path", digit=joint_name(DIGITS[column])), fontsize=9)


def _height(axes: Axes, overlay: Overlay, column: int) -> None:
    """The same fingertip's way out of the palm, against time."""
    for curves, style, _label in _lines(overlay):
        axes.plot(curves.t_s, curves.fingertips_palm_m[:, column, 0] * 1000.0, **style)
    axes.set_title(_("%(digit)s: out of the palm (mm)", digit=joint_name(DIGITS[column])), fontsize=9)
    axes.set_xlabel(_("time (s)"))


def _lines(overlay: Overlay) -> list[tuple[Curves, dict[str, Any], str]]:
    if overlay.reference is None:
        return [(overlay.hand, dict(ALONE), _("recorded hand"))]
    return [(overlay.hand, dict(PATIENT), _("patient")), (overlay.reference, dict(THERAPIST), _("therapist"))]


def _spans(values: Float64) -> Float64:
    """Largest less smallest of each column, 0 where nothing is finite, shape (D,)."""
    known = np.isfinite(values)
    high = np.where(known, values, -np.inf).max(axis=0)
    low = np.where(known, values, np.inf).min(axis=0)
    return np.where(known.any(axis=0), high - low, 0.0)


def _travel(shown: Curves, hand: Curves, column: int) -> float:
    """Extent of a fingertip in the plane that is drawn, m."""
    both = [curves.fingertips_palm_m[:, column][:, [0, 2]] for curves in (shown, hand)]
    joined = np.concatenate(both)
    return float(_spans(joined).max()) if len(joined) else 0.0


def _same_scale(axes: Axes, overlay: Overlay, column: int, extent_mm: float) -> None:
    """Centre the panel on its path and give every panel the same number of millimetres."""
    parts = [curves.fingertips_palm_m[:, column] for curves, _style, _label in _lines(overlay)]
    points = np.concatenate(parts) * 1000.0
    points = points[np.isfinite(points).all(axis=1)]
    centre = (points.max(axis=0) + points.min(axis=0)) / 2
    half = 0.58 * extent_mm
    axes.set_xlim(centre[2] - half, centre[2] + half)
    axes.set_ylim(centre[0] - half, centre[0] + half)
    axes.set_aspect("equal")


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure of this size in inches."""
    from matplotlib.figure import Figure as Canvas

    return Canvas(figsize=(width_in, height_in), layout="constrained")


def _row(figure: Figure, count: int) -> list[Axes]:
    grid: Any = figure.subplots(1, count, squeeze=False)
    return list(grid[0])


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > 1:
        figure.legend(handles, labels, loc="outside upper right", ncols=2, fontsize=9, handlelength=3.5)


def _settle(figure: Figure) -> None:
    """Lay the panels out once and for all; saving would draw everything a second time to do it."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def _said(what: str, when: str) -> str:
    """What a picture shows for who cannot see it, and of which part of the file."""
    return f"{what}, {remark(when)}" if when else what


def svg(figure: Figure, key: str, label: str) -> str:
    """The figure as an <svg> element whose ids are its own, with a label for screen readers."""
    buffer = io.StringIO()
    _settle(figure)
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{key}-\1"', text)
    text = re.sub(r'(href="|url\()#', rf"\1#{key}-", text)
    text = re.sub(r"(?<=>)[^<>]*\d\.\d[^<>]*(?=</text>)", lambda found: decimal(found[0]), text)
    words = label.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return text.replace("<svg ", f'<svg role="img" aria-label="{words}" ', 1)
