"""Real hands by name: what their device files say, and the way to open one."""

from __future__ import annotations

from pathlib import Path

from robot_iface.adapters.device_file import read_device
from robot_iface.errors import Refused
from robot_iface.ports import HandRobot
from robot_iface.types import Capabilities


def ros2_capabilities(device: str, folder: Path | None = None) -> Capabilities:
    """What a real device is and can do, from its device file alone; nothing is connected.

    Args:
        device: Its name, such as "ros2:clinic-hand".
        folder: Where device files lie; by default $REHAB_DEVICES or the user's configuration folder.

    Raises:
        Refused: It has no device file, or one that cannot be.
    """
    return read_device(device, folder).capabilities


def open_ros2(device: str, folder: Path | None = None) -> HandRobot:
    """A real device for the control loop; its ``open`` connects.

    Args:
        device: Its name, such as "ros2:clinic-hand".
        folder: Where device files lie; by default $REHAB_DEVICES or the user's configuration folder.

    Raises:
        Refused: It has no device file, or the ``ros2`` extra is not installed.
    """
    described = read_device(device, folder)
    try:
        from robot_iface.adapters.ros2_hand import Ros2Hand
    except ImportError as error:
        if (error.name or "").split(".")[0] != "cyclonedds":
            raise
        bound = "installed where a real hand is moved"
        remedy = "install the extra: pip install 'rehab-app[ros2]'"
        raise Refused("cyclonedds", "not installed", bound, remedy) from error
    return Ros2Hand(described)
