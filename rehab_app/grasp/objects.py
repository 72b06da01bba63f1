"""What is grasped: cylinder, sphere, box. Each says how far its surface is from a straight piece of a digit.

Object frame: depth out of the palm, across (towards the fingertips), along (the object's axis), origin at its
centre. Distances are negative inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.errors import Refused
from sessions.records.fields import Float64

_LARGEST_M = 10.0
_SEARCH_STEPS = 24  # to a micrometre of a phalanx
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder longer than the hand is broad.

    Attributes:
        radius_m: Radius, m.
    """

    radius_m: float

    def __post_init__(self) -> None:
        _positive("cylinder radius", self.radius_m)

    @property
    def half_depth_m(self) -> float:
        """Half the thickness that stands out of the palm, m."""
        return self.radius_m

    def distance_m(self, start_m: Float64, end_m: Float64) -> Float64:
        """Surface to segment, shape (...), from ends of shape (..., 3), m."""
        nearest = _nearest_to_origin(start_m[..., :2], end_m[..., :2])
        return np.sqrt((nearest**2).sum(axis=-1)) - self.radius_m


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball.

    Attributes:
        radius_m: Radius, m.
    """

    radius_m: float

    def __post_init__(self) -> None:
        _positive("sphere radius", self.radius_m)

    @property
    def half_depth_m(self) -> float:
        """Half the thickness that stands out of the palm, m."""
        return self.radius_m

    def distance_m(self, start_m: Float64, end_m: Float64) -> Float64:
        """Surface to segment, shape (...), from ends of shape (..., 3), m."""
        nearest = _nearest_to_origin(start_m, end_m)
        return np.sqrt((nearest**2).sum(axis=-1)) - self.radius_m


@dataclass(frozen=True, slots=True)
class Box:
    """A bar with square edges, longer than the hand is broad.

    Attributes:
        depth_m: Size out of the palm, m.
        width_m: Size towards the fingertips, m.
    """

    depth_m: float
    width_m: float

    def __post_init__(self) -> None:
        _positive("box depth", self.depth_m)
        _positive("box width", self.width_m)

    @property
    def half_depth_m(self) -> float:
        """Half the thickness that stands out of the palm, m."""
        return self.depth_m / 2

    def distance_m(self, start_m: Float64, end_m: Float64) -> Float64:
        """Surface to segment, shape (...), from ends of shape (..., 3), m: convex, so by golden section."""
        start, way = start_m[..., :2], end_m[..., :2] - start_m[..., :2]
        low, high = np.zeros(start.shape[:-1]), np.ones(start.shape[:-1])
        for _ in range(_SEARCH_STEPS):
            left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            nearer = self._of_point(start + left[..., None] * way) < self._of_point(
                start + right[..., None] * way
            )
            high, low = np.where(nearer, right, high), np.where(nearer, low, left)
        return self._of_point(start + ((low + high) / 2)[..., None] * way)

    def _of_point(self, point_m: Float64) -> Float64:
        beyond = np.abs(point_m) - np.array([self.depth_m, self.width_m]) / 2
        outside = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=-1))
        return outside + np.minimum(beyond.max(axis=-1), 0.0)


Thing = Cylinder | Sphere | Box
"""What can be grasped."""

_KINDS: dict[str, tuple[str, ...]] = {
    "cylinder": ("radius",),
    "sphere": ("radius",),
    "box": ("depth", "width"),
}


def parse_object(text: str) -> Thing:
    """The object of a text such as ``cylinder:radius=0.0225`` or ``box:depth=0.04,width=0.06`` (metres).

    Raises:
        Refused: The text names no object, or a size that is not above 0 m.
    """
    kind, _, rest = text.partition(":")
    sizes = named_sizes("object", text, rest)
    if kind not in _KINDS or set(sizes) != set(_KINDS[kind]):
        raise Refused(
            "object",
            repr(text),
            "cylinder:radius=R, sphere:radius=R or box:depth=D,width=W in metres",
            "name one of these",
        )
    if kind == "box":
        return Box(sizes["depth"], sizes["width"])
    return Cylinder(sizes["radius"]) if kind == "cylinder" else Sphere(sizes["radius"])


def named_sizes(thing: str, text: str, rest: str) -> dict[str, float]:
    """The numbers of ``name=number,name=number``; empty for an empty text.

    Args:
        thing: What is being read, for the refusal.
        text: The whole text, for the refusal.
        rest: The part to read.

    Raises:
        Refused: It is not such a list.
    """
    sizes: dict[str, float] = {}
    for part in filter(None, rest.split(",")):
        name, sign, number = (piece.strip() for piece in part.partition("="))
        if name in sizes:
            raise Refused(thing, f"{text!r} with two of {name}", "each size once", "leave one out")
        try:
            sizes[name] = float(number)
        except ValueError:
            sign = ""
        if not sign:
            raise Refused(thing, repr(text), "name=number pairs in metres", "write, for example, radius=0.03")
    return sizes


def _positive(thing: str, value_m: float) -> None:
    if not 0.0 < value_m <= _LARGEST_M:
        raise Refused(
            thing, f"{value_m:g} m", f"above 0 m and at most {_LARGEST_M:g} m", "measure the object"
        )


def _nearest_to_origin(start: Float64, end: Float64) -> Float64:
    """Point of each segment that is nearest to the origin, shape of the ends."""
    way = end - start
    square = (way**2).sum(axis=-1)
    part = np.clip(-(start * way).sum(axis=-1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return start + part[..., None] * way
