"""Between the driver's joints (its names, order, signs, zeros) and ours."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

import numpy as np

from robot_iface.adapters.device_file import Device
from robot_iface.types import DeviceState, Float64, Int64

if TYPE_CHECKING:  # the messages need the ros2 extra
    from robot_iface.adapters.ros2_messages import JointState

UNKNOWN_TEMPERATURE_C = 0.0
"""A joint state holds no temperature: the driver reports an over-temperature as a fault."""


class JointMap:
    """Translates readings and commands of one device.

    Args:
        device: The device file.
    """

    def __init__(self, device: Device) -> None:
        rows = device.joint
        self._rows = rows
        self._sign: Float64 = np.array([float(row.sign) for row in rows])
        self._offset_rad: Float64 = np.deg2rad([row.offset_deg for row in rows])
        self._names: list[str] = []
        nothing: Int64 = np.empty(0, dtype=np.int64)
        self._first, self._second, self._torque = nothing, nothing, nothing

    def missing(self, message: JointState) -> tuple[str, ...]:
        """What of the device file the driver does not report; empty when all is there."""
        wanted = [name for row in self._rows for name in (row.ros, row.second, row.torque) if name]
        names = message.name
        absent = [name for name in wanted if name not in names]
        for column in ("position", "velocity", "effort"):
            if len(getattr(message, column)) != len(names):
                absent.append(f"{column} of every joint")
        return tuple(absent)

    def state(self, message: JointState, t_ns: int, seq: int, faults: tuple[str, ...]) -> DeviceState:
        """A reading in our order, signs and zeros.

        Raises:
            OSError: The driver has ceased to report a joint.
        """
        if message.name != self._names:
            self._learn(message)
        columns = (message.position, message.velocity, message.effort)
        if len({len(column) for column in (message.name, *columns)}) != 1:
            raise OSError(errno.EPROTO, "joint state without position, velocity or effort of every joint")
        position, velocity, effort = (np.array(column, dtype=np.float64) for column in columns)
        sign = self._sign
        return DeviceState(
            t_ns=t_ns,
            seq=seq,
            q_rad=sign * position[self._first] + self._offset_rad,
            q_second_rad=sign * position[self._second] + self._offset_rad,
            dq_rad_s=sign * velocity[self._first],
            tau_nm=sign * effort[self._first],
            tau_interaction_nm=sign * effort[self._torque],
            temperature_c=UNKNOWN_TEMPERATURE_C,
            faults=faults,
        )

    def efforts(self, torque_nm: Float64) -> list[float]:
        """Torques, (J,), as efforts in the driver's order and signs."""
        return (self._sign * torque_nm).tolist()

    def positions(self, q_rad: Float64) -> list[float]:
        """Positions, (J,), in the driver's order, signs and zeros."""
        return (self._sign * (q_rad - self._offset_rad)).tolist()

    def velocities(self, dq_rad_s: Float64) -> list[float]:
        """Velocities, (J,), in the driver's order and signs."""
        return (self._sign * dq_rad_s).tolist()

    def _learn(self, message: JointState) -> None:
        """Where the joints stand in the driver's list."""
        absent = self.missing(message)
        if absent:
            raise OSError(errno.EPROTO, f"joint state without {absent[0]}")
        place = {name: index for index, name in enumerate(message.name)}
        rows = self._rows
        self._first = np.array([place[row.ros] for row in rows], dtype=np.int64)
        self._second = np.array([place[row.second or row.ros] for row in rows], dtype=np.int64)
        self._torque = np.array([place[row.torque or row.ros] for row in rows], dtype=np.int64)
        self._names = list(message.name)
