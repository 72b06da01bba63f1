"""Files and motion core know the hand by the same words, without knowing each other."""

from __future__ import annotations

from robot_iface import types
from sessions import records


def test_both_packages_name_the_hand_alike() -> None:
    assert types.DIGITS == records.DIGITS
    assert types.JOINTS == records.JOINTS
    assert types.LANDMARKS == records.LANDMARKS
    assert len(records.JOINTS) == 21
    assert len(records.LANDMARKS) == 25
