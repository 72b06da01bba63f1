"""The straps of the exoskeleton on one patient's hand: where each was donned, and whether it can follow."""

from __future__ import annotations

import numpy as np

from robot_iface.errors import Refused
from robot_iface.kinematics import HandGeometry
from robot_iface.sim.kernels import strap_geometry
from robot_iface.types import DIGITS, Float64, PatientTwin

_ALONG_SHARE = 0.6  # a strap goes round its bone beyond the middle
_SKIN_PER_LENGTH = 0.045  # half the thickness of a digit, per hand length
_LEAST_REACH_SHARE = 0.3
_LEAST_TURN, _MOST_TURN = 0.2, 3.0
_NEWTON_ROUNDS = 30
_LARGEST_SLIP_RAD = float(np.deg2rad(30.0))


def strap_rows(
    twin: PatientTwin, geometry: HandGeometry, names: tuple[str, ...], q_min_rad: Float64, q_max_rad: Float64
) -> Float64:
    """One row a driven joint, as the compiled kernels read them.

    The offset lies in the plane of flexion; axes of abduction stay where the joint is.

    Args:
        twin: The patient: how the axes stand, and which strap slips when.
        geometry: The patient's hand.
        names: The J driven joints.
        q_min_rad: Lower end of the device's range, (J,).
        q_max_rad: Upper end of the device's range, (J,).

    Returns:
        Dorsal and distal offset, distance along the bone, height of the skin, slip, time of the slip, (J, 6).

    Raises:
        Refused: A strap could not follow its link over the device's range, or the slip is no slip any more.
    """
    if not abs(twin.strap_slip_rad) <= _LARGEST_SLIP_RAD:
        slip, most = f"{np.rad2deg(twin.strap_slip_rad):.3g}°", f"{np.rad2deg(_LARGEST_SLIP_RAD):.0f}°"
        raise Refused("slip of the straps", slip, f"at most {most}", "put the device on again")
    distal_m, dorsal_m = twin.axis_offset_m
    rows = np.zeros((len(names), 6))
    for row, name in zip(rows, names, strict=True):
        flexes = not name.endswith("abduction")
        along = _ALONG_SHARE * _bone_m(geometry, name)
        row[:] = (
            dorsal_m if flexes else 0.0,
            distal_m if flexes else 0.0,
            along,
            _SKIN_PER_LENGTH * geometry.length_m,
            twin.strap_slip_rad,
            twin.slip_at_s,
        )
    for name, row, low, high in zip(names, rows, q_min_rad.tolist(), q_max_rad.tolist(), strict=True):
        _check_follows(name, row, low, high)
    return rows


def seated_rad(straps: Float64, bones_rad: Float64) -> Float64:
    """Link angles at which no strap is strained, by Newton's rule.

    Args:
        straps: One row each, (J, 6), not yet slipped.
        bones_rad: Angles of the patient's joints, (J,).
    """
    links = np.array(bones_rad, dtype=np.float64)
    for joint, row in enumerate(straps):
        if row[0] == 0.0 and row[1] == 0.0:
            continue
        for _ in range(_NEWTON_ROUNDS):
            bone, turn, _, _ = strap_geometry(float(links[joint]), row)
            links[joint] += (bones_rad[joint] - bone) / turn
    return links


def _bone_m(geometry: HandGeometry, name: str) -> float:
    """The bone that a joint is the last to turn."""
    digit, joint = name.split("_", 1)
    place = {"pip": 1, "dip": 2, "ip": 2}.get(joint, 0)
    if name.startswith("thumb_mcp"):
        place = 1
    return float(geometry.bones_m[DIGITS.index(digit), place])


def _check_follows(name: str, row: Float64, low_rad: float, high_rad: float) -> None:
    for angle in np.linspace(low_rad, high_rad, 25).tolist():
        _, turn, slide, _ = strap_geometry(angle, row)
        reach_share = 1.0 + slide / float(row[2])
        if not (_LEAST_TURN <= turn <= _MOST_TURN and reach_share >= _LEAST_REACH_SHARE):
            offset = f"{row[1] * 1e3:g} mm distal, {row[0] * 1e3:g} mm dorsal"
            at = f"what the strap of {name} can follow to {np.rad2deg(angle):.0f}°"
            raise Refused("axis offset", offset, at, "seat the hand in the device again")
