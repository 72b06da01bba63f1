"""What the panel says about a target grip: what it is, and how far the hand still has to go."""

from __future__ import annotations

import math
from html import escape

from rehab_app.services.grip_finder import FoundGrip
from rehab_app.services.grip_target import GripTarget, WayToGo
from rehab_app.web.language import _
from rehab_app.web.viewport.verdict import DIGIT_WORDS, TARGET_MM
from sessions.records import DIGITS

_BOX = (
    "border:2px solid #8a0068;border-radius:10px;padding:8px 14px 10px;margin:6px 10px;"
    "font-family:system-ui,sans-serif;color:#1f2d38;background:#fff"
)


def goal_html(found: FoundGrip, way: WayToGo | None) -> str:
    """The card of a target grip as HTML; "" where none was chosen.

    Args:
        found: What is known of it.
        way: How far the hand is, None where no hand is measured.
    """
    target = found.target
    if target is None:
        sign = "&#9888; " if found.refused else ""
        return f'<div role="status" style="{_BOX}">{sign}{escape(found.words)}</div>' if found.words else ""
    head = (
        f'<div style="font-size:12px;font-weight:700;color:#8a0068">{escape(_("Target grip"))}</div>'
        f'<div style="font-size:14px;font-weight:700">{escape(found.words)}</div>'
    )
    nobody = f'<div style="font-size:13px">{escape(_("No hand is measured now."))}</div>'
    body = nobody if way is None else _way(target, way)
    said = (escape(_("Note: %(note)s.") % {"note": note}) for note in target.notes)
    grey = "font-size:12px;color:#5a6b78;margin-top:4px"
    notes = "".join(f'<div style="{grey}">{note}</div>' for note in said)
    return f'<div role="status" style="{_BOX}">{head}{body}{notes}</div>'


def to_go(way: WayToGo) -> str:
    """The way in one line, such as "12 mm to go"; "reached" within the target distance."""
    farthest_mm = 1e3 * way.farthest_m
    return _("reached") if farthest_mm <= TARGET_MM else _("%(n)s mm to go") % {"n": f"{farthest_mm:.0f}"}


def aperture_words(target: GripTarget, way: WayToGo) -> str:
    """Such as "Aperture 48 degrees of 56"; of a robot that nobody wears, whose fingertips these are."""
    if way.aperture_rad is None:
        return _("The robot's own fingertips, from where its joints can follow this grip.")
    now, then = (f"{math.degrees(angle):.0f}" for angle in (way.aperture_rad, target.aperture_rad))
    return _("Aperture %(n)s degrees of %(m)s") % {"n": now, "m": then}


def _way(target: GripTarget, way: WayToGo) -> str:
    line = to_go(way)
    number, _gap, unit = line.partition(" ")
    if 1e3 * way.farthest_m <= TARGET_MM:
        number = f"&#10003; {escape(_('Reached'))}"
        unit = _("every fingertip within %(n)s mm") % {"n": f"{TARGET_MM:.0f}"}
    cells = "".join(
        f'<div style="text-align:center;{"font-weight:700;" if name == way.farthest else ""}">'
        f'<div style="color:#5a6b78;font-weight:400">{escape(_(DIGIT_WORDS[name]))}</div>'
        f"{f'{1e3 * away:.0f} mm' if touches else '(' + format(1e3 * away, '.0f') + ' mm)'}</div>"
        for name, away, touches in zip(DIGITS, way.fingertip_m, target.holds, strict=True)
    )
    return (
        f'<div><span style="font-size:30px;font-weight:700;line-height:1.15">{number}</span> '
        f'<span style="font-size:15px">{unit}</span></div>'
        f'<div style="display:grid;grid-template-columns:repeat(5,1fr);font-size:13px">{cells}</div>'
        f'<div style="font-size:13px;margin-top:4px">{escape(aperture_words(target, way))}</div>'
    )
