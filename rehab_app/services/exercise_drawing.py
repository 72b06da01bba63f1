"""Draws a hand in a posture: forward kinematics, seen from the palm or from the thumb's side, as SVG.

Every limb is a capsule between two joints, seen without perspective; what is nearer is drawn later. A left
hand is the mirror image of a right one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from robot_iface.kinematics import average_hand, forward
from robot_iface.types import DIGITS
from sessions.records import Side
from sessions.records.fields import Float64

View: TypeAlias = Literal["palm", "side"]
VIEWS: tuple[View, ...] = get_args(View)
_BOX_MM: dict[View, tuple[float, float, float, float]] = {
    "palm": (-70.0, -205.0, 204.0, 258.0),
    "side": (-122.0, -205.0, 160.0, 258.0),
}
_GAP_MM = 44.0
_RADII_MM = np.array(
    [
        [15.0, 11.5, 10.0, 8.5],
        [10.5, 9.5, 8.5, 7.0],
        [10.5, 9.8, 8.8, 7.2],
        [10.0, 9.2, 8.2, 6.8],
        [9.0, 8.0, 7.2, 6.0],
    ]
)
_PALM_M = np.array([[0.0, 0.021, 0.006], [0.0, -0.019, 0.006], [0.0, -0.036, 0.045]])
_PALM_MM = np.array([13.0, 13.0, 9.0, 10.5, 10.5, 10.0, 9.5])
_FOREARM_M = np.array([[0.0, 0.013, -0.06], [0.0, -0.013, -0.06], [0.0, 0.015, 0.0], [0.0, -0.015, 0.0]])
_INK, _SKIN, _PALM_INK = "#173f56", "#f4f7f9", "#dfe9ef"
_MOVING = "#f2b24c"


@dataclass(frozen=True, slots=True)
class _Shape:
    """A filled outline with the distance at which it lies.

    Attributes:
        near_m: Towards who looks; the largest is drawn last.
        path: Outline as SVG path.
        fill: Colour.
        width: Width of its ink, mm.
    """

    near_m: float
    path: str
    fill: str
    width: float = 1.6

    def svg(self) -> str:
        """The element."""
        return (
            f'<path d="{self.path}" fill="{self.fill}" stroke="{_INK}" stroke-width="{self.width}" '
            'stroke-linejoin="round"/>'
        )


def draw_pair(start_rad: Float64, end_rad: Float64, view: View, side: Side, moving: tuple[str, ...]) -> str:
    """Two postures beside each other with an arrow from the first to the second, as an SVG file.

    Args:
        start_rad: Joint angles of the first posture, shape (21,).
        end_rad: Those of the second.
        view: From where.
        side: Side of the hand.
        moving: Digits that the exercise moves: drawn darker and with a thicker line.
    """
    left, top, width, height = _BOX_MM[view]
    whole = 2 * width + _GAP_MM
    panels = "".join(
        f'<g transform="translate({shift:g} 0)">{_hand(joints, view, side, moving)}</g>'
        for joints, shift in ((start_rad, 0.0), (end_rad, width + _GAP_MM))
    )
    x, y = width + 0.5 * _GAP_MM, 0.5 * height
    arrow = (
        f'<path d="M{x - 15:g} {y:g}h22m-9-9 9 9-9 9" fill="none" stroke="{_INK}" stroke-width="5" '
        'stroke-linecap="round" stroke-linejoin="round"/>'
    )
    del left, top
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {whole:g} {height:g}">{panels}{arrow}</svg>\n'
    )


def _hand(joints_rad: Float64, view: View, side: Side, moving: tuple[str, ...]) -> str:
    """One hand inside its box, whose upper left corner is the origin."""
    left, top, width, _ = _BOX_MM[view]
    frames = forward(average_hand(), joints_rad)
    bases = frames.landmarks_m[[4, 8, 12, 16]]
    palm = np.vstack([_PALM_M, bases])
    shapes = [
        _blob(_FOREARM_M, np.full(4, 12.0), view, -1.0, _PALM_INK),
        _blob(palm, _PALM_MM, view, 0.0, _PALM_INK),
        *_limbs(frames.landmarks_m[:20].reshape(5, 4, 3), view, moving),
    ]
    body = "".join(shape.svg() for shape in sorted(shapes, key=lambda shape: shape.near_m))
    flip = (
        f"translate({width + left:g} {-top:g}) scale(-1 1)"
        if side == "left"
        else f"translate({-left:g} {-top:g})"
    )
    return f'<g transform="{flip}">{body}</g>'


def _limbs(points_m: Float64, view: View, moving: tuple[str, ...]) -> list[_Shape]:
    """A capsule for each bone of each digit; ``points_m`` has shape (5, 4, 3)."""
    shapes: list[_Shape] = []
    for digit, name in enumerate(DIGITS):
        active = name in moving
        for bone in range(3):
            ends = points_m[digit, bone : bone + 2]
            near = float(_seen(ends, view)[1].mean()) + (0.002 * bone if view == "palm" else 0.0)
            shapes.append(
                _blob(
                    ends,
                    _RADII_MM[digit, bone : bone + 2],
                    view,
                    near,
                    _MOVING if active else _SKIN,
                    2.6 if active else 1.6,
                )
            )
    return shapes


def _seen(points_m: Float64, view: View) -> tuple[Float64, Float64]:
    """Where points, (N, 3), are on the paper, (N, 2) in mm with y down, and how near, (N,) in m."""
    palmar, radial, distal = points_m.T
    across, near = (radial, palmar) if view == "palm" else (-palmar, radial)
    return 1e3 * np.stack([across, -distal], axis=1), near


def _blob(
    points_m: Float64, radii_mm: Float64, view: View, near_m: float, fill: str, width: float = 1.6
) -> _Shape:
    """The hull of balls at points, (N, 3), with those radii."""
    centres, _ = _seen(points_m, view)
    turn = np.linspace(0.0, 2.0 * np.pi, 28, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    hull = _hull((centres[:, None] + radii_mm[:, None, None] * ring).reshape(-1, 2))
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in hull) + "Z"
    return _Shape(near_m, path, fill, width)


def _hull(points: Float64) -> list[tuple[float, float]]:
    """Corners of the convex hull of points, (N, 2), in order."""
    ordered = sorted({(float(x), float(y)) for x, y in points})

    def half(run: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for one in run:
            while len(kept) > 1 and _turns_right(kept[-2], kept[-1], one):
                kept.pop()
            kept.append(one)
        return kept[:-1]

    return half(ordered) + half(ordered[::-1])


def _turns_right(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0.0
