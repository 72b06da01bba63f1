"""Cameras: one protocol, one file per source. The virtual one renders a hand and knows the truth."""

from rehab_app.cameras.frame import Camera, Frame
from rehab_app.cameras.scene import HandScene, hand_scene
from rehab_app.cameras.scripted_motion import MOTIONS, ScriptedMotion, Sway, posture, scripted_motion
from rehab_app.cameras.sensor import CLEAN, NoiseLevel
from rehab_app.cameras.virtual import Truth, VirtualCamera
from rehab_app.cameras.virtual_hand import virtual_camera
from rehab_app.cameras.worn_markers import wear_markers

__all__ = [
    "CLEAN",
    "MOTIONS",
    "Camera",
    "Frame",
    "HandScene",
    "NoiseLevel",
    "ScriptedMotion",
    "Sway",
    "Truth",
    "VirtualCamera",
    "hand_scene",
    "posture",
    "scripted_motion",
    "virtual_camera",
    "wear_markers",
]
