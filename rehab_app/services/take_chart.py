"""Bending of every joint over time, of one take or of two over each other, as an SVG file."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rehab_app.recording.take import HandMotion
from rehab_app.services.take_quality import flexion_joints
from robot_iface.types import DIGITS, JOINTS
from sessions.records.fields import Float64

_WIDTH, _HEIGHT, _GAP_X, _GAP_Y = 190.0, 92.0, 16.0, 22.0
_LEFT, _TOP, _BOTTOM = 54.0, 26.0, 34.0
_POINTS = 160
_INK, _SOFT, _LINE = "#173f56", "#52606d", "#d5dee5"
_NEW, _OLD = "#0b6fb0", "#c2571a"
_ROWS = ("MCP", "PIP", "DIP")
_THUMB_ROWS = ("CMC", "MCP", "IP")


@dataclass(frozen=True, slots=True)
class _Scale:
    """Degrees and seconds onto one small picture."""

    end_s: float
    low_deg: float
    high_deg: float

    def points(self, t_s: Float64, angle_rad: Float64) -> list[str]:
        """Lines of a curve as SVG paths, one for each part without a gap."""
        keep = np.unique(np.linspace(0, len(t_s) - 1, min(len(t_s), _POINTS)).astype(np.int64))
        x = _WIDTH * t_s[keep] / self.end_s
        y = self.height(np.rad2deg(angle_rad[keep]))
        runs: list[list[str]] = [[]]
        for one_x, one_y in zip(x, y, strict=True):
            if np.isfinite(one_y):
                runs[-1].append(f"{one_x:.1f} {one_y:.1f}")
            elif runs[-1]:
                runs.append([])
        return ["M" + "L".join(run) for run in runs if len(run) > 1]

    def height(self, degrees: Float64) -> Float64:
        """How far below the top of the picture."""
        share = (degrees - self.low_deg) / (self.high_deg - self.low_deg)
        return _HEIGHT * (1.0 - share)


def joint_chart(motion: HandMotion, before: HandMotion | None = None) -> str:
    """Bending in degrees over time in s: a column for each digit, a row for each of its joints.

    Args:
        motion: The take: a solid line.
        before: The take it was made from: a dashed line; None for none.
    """
    drawn = [motion] if before is None else [motion, before]
    scale = _scale(drawn)
    cells = "".join(_cell(column, row, scale, drawn) for column in range(5) for row in range(3))
    heads = "".join(
        _text(_left(column) + 0.5 * _WIDTH, 16.0, digit.capitalize(), 13, "middle", bold=True)
        for column, digit in enumerate(DIGITS)
    )
    width = _LEFT + 5 * (_WIDTH + _GAP_X)
    height = _TOP + 3 * (_HEIGHT + _GAP_Y) + _BOTTOM - _GAP_Y
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        f'font-family="sans-serif">{heads}{cells}</svg>\n'
    )


def _scale(drawn: list[HandMotion]) -> _Scale:
    columns = [JOINTS.index(name) for digit in DIGITS for name in flexion_joints(digit)]
    degrees = np.concatenate([np.rad2deg(one.joints_rad[:, columns]).ravel() for one in drawn])
    seen = degrees[np.isfinite(degrees)]
    low, high = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 90.0)
    return _Scale(
        max(float(one.t_s[-1]) for one in drawn),
        min(0.0, 10.0 * math.floor(low / 10.0)),
        30.0 * math.ceil(high / 30.0 + 0.01),
    )


def _cell(column: int, row: int, scale: _Scale, drawn: list[HandMotion]) -> str:
    digit = DIGITS[column]
    joint = JOINTS.index(flexion_joints(digit)[row])
    words = (_THUMB_ROWS if column == 0 else _ROWS)[row]
    parts = [f'<rect width="{_WIDTH:g}" height="{_HEIGHT:g}" fill="#fff" stroke="{_LINE}"/>']
    for degrees in np.arange(-180.0, 181.0, 30.0):
        if not scale.low_deg <= degrees <= scale.high_deg:
            continue
        y = float(scale.height(np.array([degrees]))[0])
        parts.append(f'<path d="M0 {y:.1f}h{_WIDTH:g}" stroke="{_LINE}"/>')
        if column == 0:
            parts.append(_text(-5.0, y + 4.0, f"{degrees:.0f}°", 11, "end"))
    if row == len(_ROWS) - 1:
        parts += [
            _text(0.0, _HEIGHT + 15.0, "0", 11, "start"),
            _text(_WIDTH, _HEIGHT + 15.0, f"{scale.end_s:.1f} s", 11, "end"),
        ]
    for number in reversed(range(len(drawn))):
        parts += _curve(drawn[number], joint, scale, old=number > 0)
    parts.append(_text(5.0, 13.0, words, 11, "start", bold=True))
    y = _TOP + row * (_HEIGHT + _GAP_Y)
    return f'<g transform="translate({_left(column):g} {y:g})">{"".join(parts)}</g>'


def _curve(motion: HandMotion, joint: int, scale: _Scale, *, old: bool) -> list[str]:
    look = f'stroke="{_OLD}" stroke-dasharray="5 4"' if old else f'stroke="{_NEW}"'
    return [
        f'<path d="{path}" fill="none" {look} stroke-width="2"/>'
        for path in scale.points(motion.t_s, motion.joints_rad[:, joint])
    ]


def _left(column: int) -> float:
    return _LEFT + column * (_WIDTH + _GAP_X)


def _text(x: float, y: float, words: str, size: int, anchor: str, *, bold: bool = False) -> str:
    weight, colour = (' font-weight="700"', _INK) if bold else ("", _SOFT)
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{colour}"{weight}>'
        f"{words}</text>"
    )
