"""The one big number and the few words around it. Every text is escaped: viser sanitises nothing."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import numpy as np

from rehab_app.web.language import _, marked, written
from robot_iface.types import DIGITS, Float64

TARGET_MM = 8.0
"""RMS fingertip distance up to which the hand counts as within the target [P]."""
DIGIT_WORDS = {
    "thumb": marked("thumb"),
    "index": marked("index"),
    "middle": marked("middle"),
    "ring": marked("ring"),
    "little": marked("little"),
}
_STYLES = {
    "good": ("#e7f4ec", "#14633a", "&#10003;"),
    "caution": ("#fff3d6", "#6b4a00", "&#9888;"),
    "calm": ("#eef3f7", "#1f3a4d", "&#9679;"),
    "alarm": ("#fde4e4", "#8c0f0f", "&#9632;"),
}


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the card says.

    Attributes:
        style: good, caution, calm or alarm; never colour alone, each has its sign and word.
        word: The word, such as "Within target".
        number: The number as printed, "" where there is none.
        unit: Its unit.
        detail: One short line beneath.
    """

    style: str
    word: str
    number: str = ""
    unit: str = ""
    detail: str = ""

    def html(self) -> str:
        """The card as HTML."""
        ground, ink, sign = _STYLES[self.style]
        number = ""
        if self.number:
            number = (
                f'<div style="margin:2px 0"><span style="font-size:40px;font-weight:700;line-height:1.1">'
                f'{escape(self.number)}</span> <span style="font-size:16px">{escape(self.unit)}</span></div>'
            )
        return (
            f'<div role="status" style="background:{ground};color:{ink};border-radius:10px;padding:12px 16px;'
            f'margin:6px 10px;font-family:system-ui,sans-serif;min-height:104px">'
            f'<div style="font-size:17px;font-weight:700"><span aria-hidden="true">{sign}</span> '
            f"{escape(self.word)}</div>{number}"
            f'<div style="font-size:13px">{escape(self.detail)}</div></div>'
        )


def of_error(fingertip_error_m: Float64, *, with_worst: bool = True) -> Verdict:
    """The verdict on five fingertip distances, shape (5,), m; ``with_worst`` names the worst of them."""
    error_mm = 1e3 * np.asarray(fingertip_error_m)
    rms_mm = float(np.sqrt(np.mean(error_mm**2)))
    if not np.isfinite(rms_mm):
        return Verdict("calm", _("Not measured"), detail=_("A fingertip is not seen."))
    within = rms_mm <= TARGET_MM
    worst = DIGITS[int(np.argmax(error_mm))]
    detail = _("target %(n)s mm") % {"n": f"{TARGET_MM:.0f}"}
    if with_worst:
        named = {"digit": _(DIGIT_WORDS[worst]), "n": written(float(error_mm.max()), 1)}
        detail += " · " + _("worst: %(digit)s, %(n)s mm") % named
    style, word = ("good", _("Within target")) if within else ("caution", _("Off target"))
    return Verdict(style, word, written(rms_mm, 1), "mm RMS", detail)


def lines(rows: tuple[tuple[str, str], ...]) -> str:
    """A two-column list of plain words and values as HTML."""
    cells = "".join(
        f'<div style="color:#5a6b78">{escape(name)}</div><div style="font-weight:600">{escape(value)}</div>'
        for name, value in rows
    )
    return (
        '<div style="display:grid;grid-template-columns:auto 1fr;gap:3px 14px;font-size:14px;'
        f'font-family:system-ui,sans-serif;margin:4px 14px 8px;color:#1f2d38">{cells}</div>'
    )


_SWATCHES = {
    marked("Patient, solid"): "width:14px;height:14px;background:#2e629e",
    marked("Therapist, see-through"): "width:12px;height:12px;background:#fbdcb4;border:2px dashed #cc5c00",
    marked("Target, outlined"): "width:12px;height:12px;background:#fff;border:2px solid #8a0068",
}


def legend(*, comparing: bool, target: bool) -> str:
    """Which hand is which, as HTML.

    Args:
        comparing: Whether a patient is compared with a therapist.
        target: Whether a target grip is shown.
    """
    names = list(_SWATCHES)[: 2 if comparing else 0] + list(_SWATCHES)[2:] * target
    cells = "".join(
        f'<span><span style="display:inline-block;{_SWATCHES[name]};border-radius:4px;vertical-align:-3px">'
        f"</span> {escape(_(name))}</span>"
        for name in names
    )
    return (
        '<div style="font:13px system-ui,sans-serif;margin:8px 14px;color:#1f2d38;display:flex;'
        f'flex-wrap:wrap;gap:4px 16px">{cells}</div>'
    )
