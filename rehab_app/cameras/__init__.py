"""Cameras: one protocol, one file per source. The virtual one renders a hand and knows the truth."""

from rehab_app.cameras.frame import Camera, Capture, Frame, Outage
from rehab_app.cameras.levels import LEVELS, Level
from rehab_app.cameras.listing import CameraListing, list_cameras
from rehab_app.cameras.opening import open_camera
from rehab_app.cameras.reconnecting import Reconnecting
from rehab_app.cameras.recorded import RecordedCamera
from rehab_app.cameras.scene import HandScene, hand_scene
from rehab_app.cameras.scripted_motion import MOTIONS, ScriptedMotion, Sway, posture, scripted_motion
from rehab_app.cameras.sensor import CLEAN, NoiseLevel
from rehab_app.cameras.video import VideoCamera
from rehab_app.cameras.virtual import Truth, VirtualCamera
from rehab_app.cameras.virtual_hand import FACING, virtual_camera, virtual_cameras
from rehab_app.cameras.worn_markers import wear_markers

__all__ = [
    "CLEAN",
    "FACING",
    "LEVELS",
    "MOTIONS",
    "Camera",
    "CameraListing",
    "Capture",
    "Frame",
    "HandScene",
    "Level",
    "NoiseLevel",
    "Outage",
    "Reconnecting",
    "RecordedCamera",
    "ScriptedMotion",
    "Sway",
    "Truth",
    "VideoCamera",
    "VirtualCamera",
    "hand_scene",
    "list_cameras",
    "open_camera",
    "posture",
    "scripted_motion",
    "virtual_camera",
    "virtual_cameras",
    "wear_markers",
]
