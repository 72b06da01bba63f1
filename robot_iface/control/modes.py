"""Which therapy modes are built."""

from __future__ import annotations

from robot_iface.errors import Refused
from robot_iface.types import Mode

BUILT_MODES: tuple[Mode, ...] = ("passive", "assistive")


def require_mode(mode: Mode) -> None:
    """Pass if a mode can be run.

    Raises:
        Refused: If it is not built yet.
    """
    if mode not in BUILT_MODES:
        bound = " or ".join(BUILT_MODES) + " in this version"
        raise Refused("therapy mode", mode, bound, "prescribe one of these modes")
