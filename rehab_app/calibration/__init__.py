"""Cameras calibrated from a board: lens, place beside each other and in the world; versioned files of it."""

from rehab_app.calibration.board import Board, parse_board
from rehab_app.calibration.camera import CalibratedCamera, Placement, check_size
from rehab_app.calibration.corners import Corners, Rejected, find_board
from rehab_app.calibration.files import camera_from_json, camera_to_json, load_camera, save_camera
from rehab_app.calibration.intrinsics import IntrinsicsFit, calibrate_intrinsics
from rehab_app.calibration.rectified import Rectified, rectified
from rehab_app.calibration.rig import RigFit, calibrate_rig
from rehab_app.calibration.rig_problem import Known
from rehab_app.calibration.views import views_of
from rehab_app.calibration.world import WorldFit, world_from_board

__all__ = [
    "Board",
    "CalibratedCamera",
    "Corners",
    "IntrinsicsFit",
    "Known",
    "Placement",
    "Rectified",
    "Rejected",
    "RigFit",
    "WorldFit",
    "calibrate_intrinsics",
    "calibrate_rig",
    "camera_from_json",
    "camera_to_json",
    "check_size",
    "find_board",
    "load_camera",
    "parse_board",
    "rectified",
    "save_camera",
    "views_of",
    "world_from_board",
]
