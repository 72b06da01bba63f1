"""Which therapy modes are built."""

from __future__ import annotations

from robot_iface.errors import Refused
from robot_iface.types import MODES, Mode

BUILT_MODES: tuple[Mode, ...] = MODES


def require_mode(mode: Mode) -> None:
    """Pass if a mode can be run.

    Raises:
        Refused: If there is no such mode.
    """
    if mode not in BUILT_MODES:
        bound = "one of " + ", ".join(BUILT_MODES)
        raise Refused("therapy mode", mode, bound, "prescribe one of these modes")
