"""A posture as an SVG picture: the section through the object, and the hand from the side of the palm."""

from __future__ import annotations

import math

from rehab_app.grasp.objects import Box, Sphere, Thing
from rehab_app.grasp.posture import Posture
from sessions.records import DIGITS
from sessions.records.fields import Float64

_SCALE = 2500.0  # pixels of the picture a metre
_MARGIN_PX = 30
_COLOURS = ("#b45309", "#1d4ed8", "#047857", "#7c3aed", "#be123c")


def posture_svg(posture: Posture) -> str:
    """The picture: two views to one scale, with millimetres and degrees for a reader."""
    section = _View(posture.points_m[..., [1, 0]], "seen along the object")
    palm = _View(posture.points_m[..., [1, 2]], "seen from the palm")
    width = section.width_px + palm.width_px + 3 * _MARGIN_PX
    height = max(section.height_px, palm.height_px) + 110
    thing = posture.thing
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="13">',
        f"<title>{posture.grip} grip, {posture.method}</title>",
        '<rect width="100%" height="100%" fill="white"/>',
        section.drawn(_MARGIN_PX, _palm_line(posture, section) + _section_of(thing), posture),
        palm.drawn(section.width_px + 2 * _MARGIN_PX, _band_of(thing, palm), posture),
        *_legend(posture, height),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


class _View:
    """One projection: the digits of the hand as thick lines."""

    def __init__(self, points_m: Float64, title: str) -> None:
        self._points = points_m
        self._title = title
        self.low = points_m.min(axis=(0, 1)) - 0.045
        self.high = points_m.max(axis=(0, 1)) + 0.045
        self.width_px = float(self.high[0] - self.low[0]) * _SCALE
        self.height_px = float(self.high[1] - self.low[1]) * _SCALE

    def x(self, across_m: float) -> float:
        return (across_m - float(self.low[0])) * _SCALE

    def y(self, up_m: float) -> float:
        return (float(self.high[1]) - up_m) * _SCALE

    def drawn(self, left_px: float, object_svg: str, posture: Posture) -> str:
        body = object_svg.format(x=self.x(0.0), y=self.y(0.0))
        half = [posture.hand.thumb_half_m, *posture.hand.half_m]
        for digit, colour in enumerate(_COLOURS):
            for link in range(3):
                (x1, y1), (x2, y2) = self._points[digit, link], self._points[digit, link + 1]
                body += (
                    f'<line x1="{self.x(float(x1)):.1f}" y1="{self.y(float(y1)):.1f}" '
                    f'x2="{self.x(float(x2)):.1f}" y2="{self.y(float(y2)):.1f}" stroke="{colour}" '
                    f'stroke-opacity="0.35" stroke-linecap="round" '
                    f'stroke-width="{2 * float(half[digit][link]) * _SCALE:.1f}"/>'
                )
            path = " ".join(f"{self.x(float(a)):.1f},{self.y(float(b)):.1f}" for a, b in self._points[digit])
            body += f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>'
        body += f'<text x="4" y="16">{self._title}</text>'
        return f'<g transform="translate({left_px:.0f},{_MARGIN_PX})">{body}</g>'


def _palm_line(posture: Posture, view: _View) -> str:
    """The palm's surface, from the wrist's side to the knuckles."""
    up = view.y(-posture.thing.half_depth_m)
    far = view.x(float(posture.points_m[1:, 0, 1].max()))
    return (
        f'<line x1="0" y1="{up:.1f}" x2="{far:.1f}" y2="{up:.1f}" stroke="#6b7280" stroke-dasharray="6 4"/>'
    )


def _section_of(thing: Thing) -> str:
    if isinstance(thing, Box):
        width, depth = thing.width_m * _SCALE, thing.depth_m * _SCALE
        move = f'transform="translate({-width / 2:.1f},{-depth / 2:.1f})"'
        size = f'width="{width:.1f}" height="{depth:.1f}"'
        return f'<rect x="{{x:.1f}}" y="{{y:.1f}}" {size} {move} fill="#d1d5db"/>'
    return f'<circle cx="{{x:.1f}}" cy="{{y:.1f}}" r="{thing.radius_m * _SCALE:.1f}" fill="#d1d5db"/>'


def _band_of(thing: Thing, view: _View) -> str:
    """The object from the palm: a band along its axis (a disc for a sphere)."""
    if isinstance(thing, Sphere):
        return _section_of(thing)
    half = (thing.width_m / 2 if isinstance(thing, Box) else thing.half_depth_m) * _SCALE
    return (
        f'<rect x="{view.x(0.0) - half:.1f}" y="0" width="{2 * half:.1f}" height="{view.height_px:.1f}" '
        'fill="#d1d5db"/>'
    )


def _legend(posture: Posture, height_px: float) -> list[str]:
    words = (
        f"{posture.grip} grip of {posture.hand.name}, method {posture.method}: z {1e3 * posture.z_m:.2f} mm, "
        f"alpha {math.degrees(posture.alpha_rad):.2f} deg, {len(posture.contacts)} contacts, "
        f"penetration {1e3 * posture.penetration_m:.2f} mm"
    )
    lines = [f'<text x="{_MARGIN_PX}" y="{height_px - 38:.0f}">{words}</text>']
    for index, (digit, colour) in enumerate(zip(DIGITS, _COLOURS, strict=True)):
        left = _MARGIN_PX + 90 * index
        lines.append(f'<text x="{left}" y="{height_px - 16:.0f}" fill="{colour}">{digit}</text>')
    return lines
