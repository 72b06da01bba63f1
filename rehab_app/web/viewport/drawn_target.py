"""A target grip in the scene: a third hand in outline around its object."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.grasp.objects import Box, Sphere
from rehab_app.services.grip_target import GripTarget
from rehab_app.web.viewport.outline import hand_lines_m, thing_lines_m, thing_place
from rehab_app.web.viewport.palette import TARGET, THING
from rehab_app.web.viewport.solids import Solid, ball, bar, block
from robot_iface.types import Float64

_OPACITY = 0.33


class DrawnTarget:
    """The target under one scene node; drawn anew only when it changes.

    Args:
        server: The viser server.
        name: Scene node, such as "/hand/target".
    """

    def __init__(self, server: viser.ViserServer, name: str) -> None:
        self._server, self._name = server, name
        self._shown: GripTarget | None = None
        self._nodes: list[Any] = []

    @property
    def shown(self) -> GripTarget | None:
        """The target that is drawn, None while there is none."""
        return self._shown

    def draw(self, target: GripTarget | None) -> None:
        """Draw a target, or none. Call inside ``server.atomic()``."""
        if target is self._shown:
            return
        for node in self._nodes:
            node.remove()
        self._nodes = [] if target is None else self._build(target)
        self._shown = target

    def _build(self, target: GripTarget) -> list[Any]:
        solid = _solid(target)
        thing = self._server.scene.add_mesh_simple(
            f"{self._name}/thing",
            solid.vertices_m.astype(np.float32),
            solid.faces.astype(np.uint32),
            color=THING,
            opacity=_OPACITY,
            flat_shading=isinstance(target.choice.thing, Box),
            cast_shadow=False,
            receive_shadow=False,
        )
        hand = self._lines("outline", hand_lines_m(target.geometry, target.joints_rad), TARGET, 2.0)
        return [thing, hand, self._lines("edges", thing_lines_m(target), THING, 1.5)]

    def _lines(self, part: str, lines_m: Float64, colour: tuple[int, int, int], thickness_px: float) -> Any:
        return self._server.scene.add_line_segments(
            f"{self._name}/{part}",
            lines_m.astype(np.float32),
            colour,
            thickness=thickness_px,
            thickness_units="screen",
        )


def _solid(target: GripTarget) -> Solid:
    """The object in the palm frame."""
    thing = target.choice.thing
    middle, size = thing_place(target)
    if isinstance(thing, Box):
        unit = block()
    elif isinstance(thing, Sphere):
        unit, size = ball(), size / 2
    else:
        unit, size = bar(), size / np.array([2.0, 2.0, 1.0])
    return Solid((unit.vertices_m * size) @ target.r_palm_object.T + middle, unit.faces)
