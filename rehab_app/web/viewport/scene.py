"""The room around the hands: server on loopback, light, floor, views, two hands with trails, a target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser

from rehab_app.web.language import marked
from rehab_app.web.viewport.drawn_hand import DrawnHand
from rehab_app.web.viewport.drawn_target import DrawnTarget
from rehab_app.web.viewport.palette import BRAND, FLOOR, GRID, PATIENT, THERAPIST
from rehab_app.web.viewport.private_server import PrivateServer
from rehab_app.web.viewport.trails import Trails
from robot_iface.kinematics import HandGeometry
from robot_iface.types import Float64

_FLOOR_M = -0.085
# Palm frame in the room: fingers up (z), palm to the first camera (-y), a right hand's thumb to the right.
Q_WORLD_PALM_WXYZ = (0.5**0.5, 0.0, 0.0, -(0.5**0.5))
_TARGET_M = np.array([0.0, -0.02, 0.075])
VIEWS: dict[str, tuple[float, float, float]] = {
    "Palm": (0.17, -0.30, 0.17),
    "Side": (-0.36, -0.06, 0.10),
    "Top": (0.02, -0.14, 0.42),
    "Thumb": (0.36, -0.08, 0.10),
}
"""Camera positions in the room, m, all looking at the middle of the hand."""


VIEW_WORDS = {
    "Palm": marked("Palm"),
    "Side": marked("Side"),
    "Top": marked("Top"),
    "Thumb": marked("Thumb"),
}
"""Their names, to be translated."""


@dataclass(frozen=True, slots=True)
class Room:
    """What is drawn in a viewport.

    Attributes:
        server: The viser server, on loopback only.
        patient: The measured hand.
        therapist: The reference, a translucent ghost on the same palm.
        patient_trail: Fingertip trails of the patient.
        therapist_trail: Fingertip trails of the therapist, dashed.
        target: A target grip in outline, on the same palm.
    """

    server: viser.ViserServer
    patient: DrawnHand
    therapist: DrawnHand
    patient_trail: Trails
    therapist_trail: Trails
    target: DrawnTarget

    def draw(self, geometry: HandGeometry, patient: Float64 | None, therapist: Float64 | None) -> None:
        """Draw the hands at joint angles (21,) rad; None hides a hand. Call inside ``server.atomic()``."""
        for hand, joints in ((self.patient, patient), (self.therapist, therapist)):
            known = joints is not None and bool(np.isfinite(joints).all())
            hand.show(known)
            hand.fit(geometry)
            if joints is not None and known:
                hand.move(joints)


def furnish(label: str, geometry: HandGeometry) -> Room:
    """Open a viser server on loopback and furnish its scene.

    Args:
        label: Title of the browser tab.
        geometry: The hand to draw first.

    Raises:
        Refused: No loopback port is free for it.
    """
    server = PrivateServer(label)
    server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=BRAND)
    server.scene.set_up_direction("+z")
    server.scene.set_background_image(np.full((2, 2, 3), FLOOR, dtype=np.uint8))
    _light(server)
    server.scene.add_frame("/hand", show_axes=False, wxyz=Q_WORLD_PALM_WXYZ)
    patient = DrawnHand(server, "/hand/patient", geometry, PATIENT, palm=True)
    therapist = DrawnHand(server, "/hand/therapist", geometry, THERAPIST, palm=False)
    patient_trail = Trails(server, "/hand/patient_trail", PATIENT)
    therapist_trail = Trails(server, "/hand/therapist_trail", THERAPIST)
    server.initial_camera.position = VIEWS["Palm"]
    server.initial_camera.look_at = tuple(_TARGET_M)
    server.initial_camera.up = (0.0, 0.0, 1.0)
    target = DrawnTarget(server, "/hand/target")
    return Room(server, patient, therapist, patient_trail, therapist_trail, target)


def look_from(client: viser.ClientHandle, view: str) -> None:
    """Move one browser's camera to a named view."""
    with client.atomic():
        client.camera.up_direction = (0.0, 0.0, 1.0)
        client.camera.position = VIEWS[view]
        client.camera.look_at = tuple(_TARGET_M)


def _light(server: viser.ViserServer) -> None:
    """Even light from above the camera, a soft shadow, a quiet floor."""
    server.scene.configure_default_lights(enabled=False)
    server.scene.configure_environment_map(None)
    server.scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(205, 212, 222), intensity=2.0
    )
    server.scene.add_light_directional(
        "/light/sun", intensity=1.9, cast_shadow=True, position=(0.25, -0.55, 0.9)
    )
    server.scene.add_grid(
        "/floor",
        width=1.2,
        height=1.2,
        plane="xy",
        cell_size=0.02,
        section_size=0.1,
        cell_color=GRID,
        section_color=(200, 208, 216),
        shadow_opacity=0.18,
        position=(0.0, 0.0, _FLOOR_M),
        fade_distance=1.6,
    )
