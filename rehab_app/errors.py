"""Refusals of the whole application.

The packages below do not know each other, so each has a ``Refused`` of its own with the same four fields;
here they meet. The application raises that of ``sessions``; whoever catches, catches ``REFUSALS``.
"""

from __future__ import annotations

from robot_iface.errors import Refused as RobotRefused
from sessions.errors import NoAnswer, Refused

__all__ = ["REFUSALS", "NoAnswer", "Refused", "RobotRefused"]

REFUSALS = (Refused, RobotRefused)
