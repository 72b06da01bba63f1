"""The motion process: ``python -m robot_iface LINK PAGE``, two descriptors that ``MotionClient`` hands on."""

from __future__ import annotations

import signal
import socket
import sys

from robot_iface.build import open_rig
from robot_iface.link import SharedPage, Wire, serve


def main(arguments: list[str]) -> int:
    """Serve the app at the other end of the link until it is gone; 2 for wrong arguments."""
    if len(arguments) != 2 or not all(argument.isdigit() for argument in arguments):
        sys.stderr.write("python -m robot_iface is started by the app; use its pages, or rehab-app play\n")
        return 2
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the app decides; a lost app is braked for
    link, page = (int(argument) for argument in arguments)
    wire = Wire(socket.socket(fileno=link))
    shared = SharedPage(page)
    try:
        serve(wire, shared, open_rig)
    finally:
        wire.close()
        shared.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
