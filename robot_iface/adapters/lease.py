"""A device belongs to one process of this computer at a time."""

from __future__ import annotations

import socket

from robot_iface.errors import Refused


class Lease:
    """Exclusive use of a device, given back by ``release`` or by the end of the process, however it ends.

    It is a name in the kernel's list of sockets: a crash leaves no file behind, and nobody has to clean up.

    Args:
        device: Name of the device.

    Raises:
        Refused: Another process has it.
    """

    def __init__(self, device: str) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            self._socket.bind(f"\0rehab-device-{device}")
        except OSError as error:
            self._socket.close()
            bound = "free: one process at a time may move a device"
            remedy = "end the other run or wait until it has ended"
            raise Refused(f"device {device}", "in use by another process", bound, remedy) from error

    def release(self) -> None:
        """Give the device back."""
        self._socket.close()
