"""Charts of progress as inline SVG: range with its detectable change, error with stiffness, dose, pain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from sessions.reports.figures import PATIENT, THERAPIST, drawing, new_figure, svg
from sessions.reports.language import _
from sessions.reports.past import Past
from sessions.reports.progress import Line, Progress, line, moved_joints
from sessions.reports.verdict import HELPED, stiffness_of
from sessions.reports.wording import joint_name

MOST_JOINTS = 6
_BLUE, _ORANGE = PATIENT["color"], THERAPIST["color"]
_BAND = "#cfe3f1"
_BARS: dict[str, Any] = {"markersize": 5, "linewidth": 1.0, "capsize": 2}


@drawing()
def leading_picture(progress: Progress, leading: Line | None, key: str) -> str:
    """One joint over the sessions, large: what a patient looks at."""
    if leading is None:
        return ""
    figure = new_figure(7.4, 3.2)
    axes: Any = figure.subplots()
    _range(axes, progress, leading)
    axes.set_xlabel(_("session"))
    axes.set_ylabel(_("angle from end to end (°)"))
    _legend(figure, axes)
    return svg(figure, key, _("Range of the %(joint)s over the sessions", joint=joint_name(leading.subject)))


@drawing()
def ranges_picture(progress: Progress, key: str) -> str:
    """Ranges of the joints that moved most, each with the band in which a change cannot be told."""
    lines = [line(progress, "range_of_motion", joint) for joint in moved_joints(progress.pasts)]
    known = [item for item in lines if item is not None]
    chosen = sorted(known, key=lambda item: -(item.now.value or 0.0))[:MOST_JOINTS]
    if not chosen or len(progress.pasts) < 2:
        return ""
    rows = (len(chosen) + 2) // 3
    figure = new_figure(7.4, 1.9 * rows + 0.4)
    grid: Any = figure.subplots(rows, 3, squeeze=False, sharex=True)
    for place, axes in enumerate(grid.flat):
        if place >= len(chosen):
            axes.set_visible(False)
            continue
        _range(axes, progress, chosen[place])
        axes.set_title(joint_name(chosen[place].subject), fontsize=9)
        axes.xaxis.set_tick_params(labelbottom=True)
        if place % 3 == 0:
            axes.set_ylabel(_("range (°)"))
        if place >= len(chosen) - 3:
            axes.set_xlabel(_("session"))
    _legend(figure, grid.flat[0])
    return svg(
        figure, key, _("Range of motion over the sessions, with the minimal detectable change as a band")
    )


@drawing()
def support_picture(progress: Progress, key: str) -> str:
    """Error above, and below it the stiffness that it was obtained at: one is nothing without the other."""
    error = [math.degrees(past.value("joint_rmse")) for past in progress.pasts]
    stiffness = [stiffness_of(past) for past in progress.pasts]
    if np.count_nonzero(np.isfinite(error) & np.isfinite(stiffness)) < 2:
        return ""
    figure = new_figure(7.4, 3.3)
    above, below = figure.subplots(2, 1, sharex=True)
    number = np.arange(1, len(error) + 1)
    shown = np.where(np.isfinite(stiffness), error, np.nan)
    above.plot(number, shown, color=_BLUE, marker="o", markersize=4, linewidth=1.3)
    above.set_ylabel(_("joint error\n(° RMS)"))
    below.plot(number, stiffness, color=_ORANGE, marker="s", markersize=4, linewidth=1.3, linestyle="--")
    below.set_ylabel(_("stiffness\n(Nm/rad)"))
    below.set_xlabel(_("session"))
    for axes in (above, below):
        axes.set_ylim(bottom=0.0)
    _whole_numbers(below, len(error))
    return svg(figure, key, _("Joint error over the sessions, and below it the stiffness it was obtained at"))


@drawing()
def dose_picture(progress: Progress, key: str) -> str:
    """Repetitions by session, those that the patient started hatched; the plan as a line."""
    if not progress.pasts:
        return ""
    made = [past.value("repetitions") for past in progress.pasts]
    own = [past.value("repetitions_by_patient") for past in progress.pasts]
    figure = new_figure(7.4, 2.2)
    axes: Any = figure.subplots()
    number = np.arange(1, len(made) + 1)
    _bars(axes, np.nan_to_num(made), facecolor=_BAND, label=_("repetitions"))
    _bars(axes, np.nan_to_num(own), facecolor="none", hatch="////", label=_("started by the patient"))
    for place, value in zip(number, made, strict=True):
        if math.isnan(value):
            axes.text(place, 0.0, _("not\nmeasured"), ha="center", va="bottom", fontsize=7)
    if progress.ordered:
        axes.axhline(progress.ordered, color=_ORANGE, linestyle=(0, (4, 2)), label=_("plan"))
    highest = max(np.nan_to_num(made).max(), np.nan_to_num(own).max(), progress.ordered or 0)
    axes.set_ylim(0.0, 1.05 * highest or 1.0)
    axes.set_xlim(0.4, len(made) + 0.6)
    axes.set_ylabel(_("repetitions"))
    axes.set_xlabel(_("session"))
    _whole_numbers(axes, len(made))
    _legend(figure, axes)
    return svg(figure, key, _("Repetitions by session"))


def _bars(axes: Any, heights: Any, **style: Any) -> None:
    """Bars from 0 at 1, 2, 3 ...: one drawing, where ``bar`` makes hundreds that are each laid out."""
    from matplotlib.collections import PolyCollection

    left = np.arange(1, len(heights) + 1) - 0.35
    x = np.column_stack((left, left, left + 0.7, left + 0.7))
    y = np.column_stack((0.0 * left, heights, heights, 0.0 * left))
    axes.add_collection(PolyCollection(list(np.stack((x, y), axis=-1)), edgecolor=_BLUE, **style))


@drawing()
def pain_picture(progress: Progress, key: str) -> str:
    """Pain as it was told, by day; empty below two entries."""
    if len(progress.pains) < 2:
        return ""
    figure = new_figure(7.4, 1.8)
    axes: Any = figure.subplots()
    start_ns = progress.pains[0][0]
    days = [(utc_ns - start_ns) / 86_400e9 for utc_ns, _score in progress.pains]
    axes.plot(
        days,
        [score for _utc_ns, score in progress.pains],
        color=_ORANGE,
        marker="D",
        markersize=4,
        linewidth=1,
    )
    axes.set_ylim(-0.4, 10.4)
    axes.set_ylabel(_("pain, 0 to 10"))
    axes.set_xlabel(_("days since the first entry"))
    return svg(figure, key, _("Pain over time"))


def _range(axes: Any, progress: Progress, shown: Line) -> None:
    """Circles where the patient moved, squares where the robot did; bars are 95 % intervals."""
    values, halves = _series(progress.pasts, shown.name, shown.subject)
    number = np.arange(1, len(values) + 1)
    if shown.baseline is not None and shown.baseline.value is not None and math.isfinite(shown.change.bound):
        middle, bound = math.degrees(shown.baseline.value), math.degrees(shown.change.bound)
        axes.axhspan(middle - bound, middle + bound, color=_BAND, alpha=0.7, label=_("no change can be told"))
    told: set[str] = set()
    for modes in dict.fromkeys(past.modes for past in progress.pasts):
        chosen = np.array([past.modes == modes for past in progress.pasts])
        if not np.isfinite(values[chosen]).any():
            continue
        by_robot = bool(HELPED & set(modes))
        words = _("robot moved") if by_robot else _("patient moved")
        style = {"marker": "s", "markerfacecolor": "white"} if by_robot else {"marker": "o"}
        bars = np.nan_to_num(halves[chosen])
        label = "_" if words in told else words  # matplotlib leaves out what begins with a dash
        axes.errorbar(number[chosen], values[chosen], bars, color=_BLUE, label=label, **_BARS, **style)
        told.add(words)
    axes.margins(y=0.25)
    _whole_numbers(axes, len(values))


def _series(pasts: Sequence[Past], name: str, subject: str) -> tuple[Any, Any]:
    """Values and half intervals in degrees, NaN where missing."""
    found = [past.number(name, subject) for past in pasts]
    values = [math.nan if item is None or item.value is None else math.degrees(item.value) for item in found]
    halves = [
        math.nan
        if item is None or item.low is None or item.high is None
        else math.degrees(item.high - item.low) / 2
        for item in found
    ]
    return np.array(values), np.array(halves)


def _whole_numbers(axes: Any, count: int) -> None:
    step = max(1, math.ceil(count / 10))
    axes.set_xticks(np.arange(1, count + 1, step))
    axes.set_xlim(0.4, count + 0.6)


def _legend(figure: Any, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper right", ncols=3, fontsize=8)
