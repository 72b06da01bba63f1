"""Names that a person gave to markers by pointing at them in the first picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.tracking import Labels
from sessions.errors import Refused

_FORM = "NAME=U,V in pixels of the first picture"


def labels_of(texts: Sequence[str]) -> Labels | None:
    """Labels out of texts such as ``index_pip=312.5,201``.

    Args:
        texts: One for each marker, u to the right and v down, in px.

    Returns:
        The labels, None where there is no text.

    Raises:
        Refused: A text is not of that form, or names a marker a second time.
    """
    if not texts:
        return None
    names: list[str] = []
    pixels: list[tuple[float, float]] = []
    for text in texts:
        name, pixel = _parted(text)
        if name in names:
            raise Refused("label", f"naming {name} twice", "each marker once", "leave one out")
        names.append(name)
        pixels.append(pixel)
    return Labels(tuple(names), np.array(pixels, dtype=np.float64))


def check_labels(labels: Labels, protocol: MarkerProtocol, camera: Intrinsics) -> None:
    """Refuse labels that name no marker of the protocol, or that lie outside the picture.

    Args:
        labels: What a person pointed at.
        protocol: The markers.
        camera: Camera of the picture.

    Raises:
        Refused: One sentence says which.
    """
    for name, (u_px, v_px) in zip(labels.names, labels.pixel_px.tolist(), strict=True):
        if name not in protocol.names:
            raise Refused(
                "label",
                repr(name[:40]),
                "one of " + ", ".join(protocol.names),
                "name markers of the protocol",
            )
        if not (0.0 <= u_px < camera.width_px and 0.0 <= v_px < camera.height_px):
            raise Refused(
                f"label {name}",
                f"at {u_px:g}, {v_px:g} px",
                f"inside the picture of {camera.width_px} x {camera.height_px} px",
                "point at the marker in the first picture",
            )


def _parted(text: str) -> tuple[str, tuple[float, float]]:
    """Name and pixel of one text."""
    name, equals, place = text.strip().rpartition("=")
    parts = place.split(",")
    try:
        u_px, v_px = (float(part) for part in parts)
    except ValueError:
        u_px = v_px = math.nan
    if not name.strip() or not equals or not (math.isfinite(u_px) and math.isfinite(v_px)):
        raise Refused("label", repr(text[:40]), _FORM, "write it as index_pip=312,201")
    return name.strip(), (u_px, v_px)
