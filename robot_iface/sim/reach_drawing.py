"""The trial as a picture, after Figure 5.12: joints in space, seen from above, and joint angles over time."""

from __future__ import annotations

import numpy as np

from robot_iface.sim.reach import Grasp
from robot_iface.types import DIGITS, Float64

_COLOURS = ("#b3425b", "#2f6db3", "#2e8b57", "#b07d1e", "#6b4fa0")
_SIDE_PX, _MARGIN_PX, _TOP_PX = 420.0, 50.0, 40.0
_WIDTH_PX, _HEIGHT_PX = 2 * _SIDE_PX + 3 * _MARGIN_PX, _SIDE_PX + _TOP_PX + 90.0
_LARGEST_DEG = 90.0
_EVERY = 4  # a point every 40 ms is as smooth to the eye as one every 10
_DASHED = ' stroke-dasharray="4 3"'


def draw_reach(grasp: Grasp) -> str:
    """The trial as SVG: left the paths of all joints from above, right ordered (dashed) and actual angles.

    Args:
        grasp: The trial.
    """
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH_PX:g}" height="{_HEIGHT_PX:g}"'
        f' font-family="sans-serif" font-size="12">',
        f'<rect width="{_WIDTH_PX:g}" height="{_HEIGHT_PX:g}" fill="#ffffff"/>',
        *_from_above(grasp),
        *_over_time(grasp),
        *_legend(),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _from_above(grasp: Grasp) -> list[str]:
    points, middle = grasp.record.points_m, grasp.record.object_m[-1]
    flat = np.concatenate([points[..., :2].reshape(-1, 2), grasp.record.object_m[:, :2]])
    low, high = flat.min(axis=0) - 0.03, flat.max(axis=0) + 0.03
    scale = _SIDE_PX / float((high - low).max())

    def place(xy_m: Float64) -> Float64:
        return np.stack(
            [_MARGIN_PX + scale * (xy_m[..., 0] - low[0]), _TOP_PX + scale * (high[1] - xy_m[..., 1])],
            axis=-1,
        )

    x, y = place(middle[:2])
    parts = [
        _frame(_MARGIN_PX, "joint paths from above, x right and y up in the MIT-Manus frame; bar 50 mm"),
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{scale * grasp.cylinder.radius_m:.1f}" fill="#dddddd"/>',
        f'<path d="M{_MARGIN_PX + 10:g} {_TOP_PX + _SIDE_PX - 10:g} h{0.05 * scale:.1f}" stroke="#000000"/>',
    ]
    for digit, colour in enumerate(_COLOURS):
        parts += [_line(place(points[:, digit, at, :2]), colour) for at in range(4)]
        ends = " ".join(f"{a:.1f},{b:.1f}" for a, b in place(points[-1, digit, :, :2]))
        parts.append(f'<path d="M{ends}" fill="none" stroke="{colour}" stroke-width="3" opacity="0.4"/>')
    return parts


def _over_time(grasp: Grasp) -> list[str]:
    record, left = grasp.record, 2 * _MARGIN_PX + _SIDE_PX
    parts = [
        _frame(left, f"MCP and PIP over {record.t_s[-1]:g} s, 0 to {_LARGEST_DEG:g} deg; ordered dashed")
    ]
    across = left + _SIDE_PX * record.t_s / record.t_s[-1]
    for digit, colour in enumerate(_COLOURS):
        for joint in (1, 2):
            for angle, dashed in ((record.reference_rad, _DASHED), (record.joints_rad, "")):
                share = np.clip(np.rad2deg(angle[:, digit, joint]) / _LARGEST_DEG, 0.0, 1.0)
                up = _TOP_PX + _SIDE_PX * (1.0 - share)
                parts.append(_line(np.stack([across, up], axis=1), colour, dashed))
    return parts


def _legend() -> list[str]:
    y = _TOP_PX + _SIDE_PX + 40.0
    return [
        f'<text x="{_MARGIN_PX + 90 * digit:g}" y="{y:g}" fill="{colour}">{DIGITS[digit]}</text>'
        for digit, colour in enumerate(_COLOURS)
    ]


def _frame(left_px: float, title: str) -> str:
    return (
        f'<rect x="{left_px:g}" y="{_TOP_PX:g}" width="{_SIDE_PX:g}" height="{_SIDE_PX:g}" fill="none"'
        f' stroke="#888888"/><text x="{left_px:g}" y="{_TOP_PX - 10:g}">{title}</text>'
    )


def _line(points_px: Float64, colour: str, dashed: str = "") -> str:
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in (*points_px[:-1:_EVERY], points_px[-1]))
    return f'<polyline points="{points}" fill="none" stroke="{colour}"{dashed}/>'
