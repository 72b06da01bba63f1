"""One hand in the scene: instanced solids that are moved, never added again."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from rehab_app.web.viewport.hand_shape import HandShape
from rehab_app.web.viewport.palette import Look, Rgb
from rehab_app.web.viewport.solids import ball, tapered_bone
from robot_iface.kinematics import HandGeometry
from robot_iface.types import Float64


class DrawnHand:
    """A hand under one scene node.

    Args:
        server: The viser server.
        name: Scene node, such as "/hand/patient".
        geometry: The hand to draw first.
        look: Colours and opacity.
        palm: Whether palm and forearm are drawn (two hands on one palm need only one).
    """

    def __init__(
        self, server: viser.ViserServer, name: str, geometry: HandGeometry, look: Look, *, palm: bool
    ) -> None:
        self._server, self._name, self._look, self._palm = server, name, look, palm
        self._nodes: list[Any] = []
        self._visible = True
        self._build(geometry)

    def fit(self, geometry: HandGeometry) -> None:
        """Draw another person's hand from now on; nothing happens if it is the same."""
        if geometry is self._shape.geometry:
            return
        for node in self._nodes:
            node.remove()
        self._build(geometry)

    def move(self, joints_rad: Float64) -> None:
        """Take a posture, (21,) rad. Call inside ``server.atomic()``."""
        segments, balls = self._shape.pose(joints_rad)
        self._segments.batched_positions = segments.p_palm_m.astype(np.float32)
        self._segments.batched_wxyzs = segments.q_palm_wxyz.astype(np.float32)
        self._balls.batched_positions = balls.p_palm_m.astype(np.float32)
        self._balls.batched_wxyzs = balls.q_palm_wxyz.astype(np.float32)

    def show(self, visible: bool) -> None:
        """Show or hide the whole hand."""
        if visible == self._visible:
            return
        self._visible = visible
        for node in self._nodes:
            node.visible = visible

    def _build(self, geometry: HandGeometry) -> None:
        self._shape = shape = HandShape(geometry)
        segments, balls = shape.pose(np.zeros(21))
        self._segments: Any = self._instances("segments", tapered_bone(), segments, shape.segment_scales_m)
        self._balls: Any = self._instances("balls", ball(), balls, shape.ball_scales_m)
        colours = np.tile(_linear(self._look.skin), (25, 1))
        colours[20:] = _linear(self._look.nail)
        self._balls.batched_colors = colours
        self._nodes = [self._segments, self._balls]
        if self._palm:
            self._nodes.append(self._still("palm", shape.palm()))
        for node in self._nodes:
            node.visible = self._visible

    def _instances(self, part: str, solid: Any, bodies: Any, scales_m: Float64) -> Any:
        return self._server.scene.add_batched_meshes_simple(
            f"{self._name}/{part}",
            solid.vertices_m.astype(np.float32),
            solid.faces.astype(np.uint32),
            bodies.q_palm_wxyz.astype(np.float32),
            bodies.p_palm_m.astype(np.float32),
            batched_scales=scales_m.astype(np.float32),
            batched_colors=np.tile(_linear(self._look.skin), (len(scales_m), 1)),
            opacity=self._look.opacity,
            lod="off",
            cast_shadow=self._look.opacity is None,
            receive_shadow=False,
        )

    def _still(self, part: str, solid: Any) -> Any:
        return self._server.scene.add_mesh_simple(
            f"{self._name}/{part}",
            solid.vertices_m.astype(np.float32),
            solid.faces.astype(np.uint32),
            color=self._look.skin,
            opacity=self._look.opacity,
            cast_shadow=self._look.opacity is None,
            receive_shadow=False,
        )


def _linear(colour: Rgb) -> Any:
    """An sRGB colour as instances want it: viser converts the colour of a mesh, not those of instances."""
    return np.round(255.0 * (np.array(colour) / 255.0) ** 2.2).astype(np.uint8)
