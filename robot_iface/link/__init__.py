"""The link between the app and the motion process."""

from robot_iface.link.client import MotionClient
from robot_iface.link.page import SharedPage
from robot_iface.link.server import serve
from robot_iface.link.wire import Wire, WireClosed
from robot_iface.runtime import LiveSample

__all__ = ["LiveSample", "MotionClient", "SharedPage", "Wire", "WireClosed", "serve"]
