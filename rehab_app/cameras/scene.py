"""Whose hand moves before the virtual camera, with which markers on it, and where the camera stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from rehab_app.cameras.paper_markers import PlacedMarkers
from rehab_app.cameras.scripted_motion import OPEN_S, ScriptedMotion
from rehab_app.cameras.skin import Capsules, hand_skin
from rehab_app.geometry.view import View
from rehab_app.hand.marker_model import MarkerModel
from robot_iface.kinematics import forward
from sessions.records.fields import Float64

_TILT_RAD = float(np.deg2rad(25.0))
_UPRIGHT = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Palm to camera for a hand held up with its back to the camera: the image shows the fingers on top."""


@dataclass(frozen=True, slots=True)
class PosedHand:
    """The scene at one instant, in the camera frame (fields as in ``Truth``)."""

    joints_rad: Float64
    p_camera_palm_m: Float64
    rotation_camera_palm: Float64
    landmarks_camera_m: Float64
    markers: PlacedMarkers
    skin: Capsules


@dataclass(frozen=True, slots=True)
class HandScene:
    """A hand, its markers, its movement and its place.

    Attributes:
        worn: The hand and the markers on it.
        motion: What it does.
        sway_phase_rad: Phases of the sway: three sines for each of 3 shifts and 3 turns, shape (6, 3).
        p_camera_palm_m: Where the wrist is held, shape (3,).
        tilt_rad: By how much the fingers lean towards the camera; it keeps flexed fingers' backs in view.
        roll_rad: By how much the held-up hand is turned about the line of sight.
    """

    worn: MarkerModel
    motion: ScriptedMotion
    sway_phase_rad: Float64
    p_camera_palm_m: Float64
    tilt_rad: float = _TILT_RAD
    roll_rad: float = 0.0

    def at(self, t_s: float) -> PosedHand:
        """The scene ``t_s`` seconds after its start."""
        joints = self.motion.joints_at(np.array([t_s]))[0]
        frames = forward(self.worn.geometry, joints)
        shift, turn = self._sway(t_s)
        rotation = Rotation.from_rotvec(turn).as_matrix() @ _held(self.tilt_rad, self.roll_rad) @ _UPRIGHT
        origin = self.p_camera_palm_m + shift
        points, normals = self.worn.positions(joints), self.worn.normals(joints)
        skin = hand_skin(self.worn.geometry, frames)
        return PosedHand(
            joints,
            origin,
            rotation,
            frames.landmarks_m @ rotation.T + origin,
            PlacedMarkers(points @ rotation.T + origin, normals @ rotation.T),
            Capsules(skin.begin_m @ rotation.T + origin, skin.end_m @ rotation.T + origin, skin.radius_m),
        )

    def _sway(self, t_s: float) -> tuple[Float64, Float64]:
        """Shift in m and turn in rad, both (3,): nothing while the hand is still, full a second later."""
        sway = self.motion.sway
        ramp = float(np.clip(t_s - OPEN_S, 0.0, 1.0))
        ramp = ramp * ramp * (3.0 - 2.0 * ramp)
        rates = 2.0 * np.pi * sway.rate_hz * np.array([1.0, 0.61, 0.37])
        waves = np.sin(rates * t_s + self.sway_phase_rad) @ np.array([0.2, 0.35, 0.45])
        return ramp * sway.amplitude_m * waves[:3], ramp * sway.amplitude_rad * waves[3:]


def seen_from(posed: PosedHand, view: View) -> PosedHand:
    """The same instant in the frame of another camera."""
    turn, origin = view.rotation_tracking_camera, view.p_tracking_camera_m
    markers, skin = posed.markers, posed.skin
    return PosedHand(
        posed.joints_rad,
        (posed.p_camera_palm_m - origin) @ turn,
        turn.T @ posed.rotation_camera_palm,
        (posed.landmarks_camera_m - origin) @ turn,
        PlacedMarkers((markers.p_camera_m - origin) @ turn, markers.normal @ turn),
        Capsules((skin.begin_m - origin) @ turn, (skin.end_m - origin) @ turn, skin.radius_m),
    )


def hand_scene(
    worn: MarkerModel,
    motion: ScriptedMotion,
    rng: np.random.Generator,
    *,
    distance_m: float = 0.70,
) -> HandScene:
    """A hand held up before the camera, its sway drawn from ``rng``."""
    where = np.array([0.0, 0.45 * worn.geometry.length_m, distance_m])
    return HandScene(worn, motion, rng.uniform(0.0, 2.0 * np.pi, (6, 3)), where)


def _held(tilt_rad: float, roll_rad: float) -> Float64:
    """Turn about the camera's x axis that brings the fingertips of a held-up hand nearer, then about z."""
    roll = Rotation.from_rotvec([0.0, 0.0, roll_rad]).as_matrix()
    held: Float64 = roll @ Rotation.from_rotvec([tilt_rad, 0.0, 0.0]).as_matrix()
    return held
