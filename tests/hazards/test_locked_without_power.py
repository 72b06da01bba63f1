"""Hazard 5: a device that locks without power traps the fingers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.safety import Supervisor, shipped_limits


@pytest.mark.parametrize(
    ("unpowered", "release", "accepted"),
    [("locked", False, False), ("locked", True, True), ("damped", False, True), ("free", False, True)],
)
def test_a_worn_device_that_locks_needs_a_quick_release(
    rigid: Any, unpowered: str, release: bool, accepted: bool
) -> None:
    hand = rigid.RigidHand(unpowered=unpowered, quick_release=release)
    limits = shipped_limits(rigid.NAMES, np.zeros(3), np.full(3, 1.6))
    supervisor = Supervisor(hand, limits, rigid.Button(), rigid.PERIOD_NS)
    if accepted:
        supervisor.start()
        return
    with pytest.raises(Refused, match="quick release"):
        supervisor.start()
    assert hand.log == [], "the device was not even opened"
