"""Colours of the viewport. Hands differ for every colour vision, and in form as well."""

from __future__ import annotations

from dataclasses import dataclass

Rgb = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Look:
    """How a hand is drawn.

    Attributes:
        skin: Colour of the hand.
        nail: Colour of the nails, which show where the back of the hand is.
        opacity: None is solid.
        trail: Colour of the fingertips' trails.
        dashed: Whether the trails are dashed.
    """

    skin: Rgb
    nail: Rgb
    opacity: float | None
    trail: Rgb
    dashed: bool


# viser's lights pale every colour: these are darker than they will look.
PATIENT = Look(skin=(58, 118, 186), nail=(190, 212, 236), opacity=None, trail=(0, 72, 148), dashed=False)
THERAPIST = Look(skin=(230, 120, 10), nail=(250, 190, 110), opacity=0.42, trail=(204, 92, 0), dashed=True)
SECOND = Look(skin=(0, 112, 92), nail=(150, 214, 196), opacity=0.6, trail=(0, 92, 74), dashed=False)
"""A second recording that the first is compared with."""
TARGET: Rgb = (138, 0, 104)
"""Outline of a target grip: lines only, nothing filled."""
THING: Rgb = (120, 126, 134)
"""What a target grip goes around."""
BRAND: Rgb = (15, 98, 138)
FLOOR: Rgb = (250, 251, 252)
GRID: Rgb = (222, 228, 234)
