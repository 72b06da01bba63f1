"""Hazard 14, the part of the motion core: stop works in every state and whatever else is wrong, and stays."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.types import SafetyState

SITUATIONS = {
    "ready": lambda rig: None,
    "ramp-in": lambda rig: (rig.supervisor.enable_edge(), rig.run(100)),
    "active": lambda rig: (rig.supervisor.enable_edge(), rig.run(1100)),
    "hold": lambda rig: (rig.supervisor.enable_edge(), rig.run(1100), rig.run(1, enable_held=False)),
    "compliant": lambda rig: (rig.supervisor.enable_edge(), rig.run(1100), load(rig), rig.run(1)),
}


def load(rig: Any) -> None:
    rig.hand.corrupt = lambda state: dataclasses.replace(state, tau_interaction_nm=np.full(3, 0.4))


@pytest.mark.parametrize("situation", SITUATIONS)
def test_stop_acts_in_its_tick_and_stays_until_a_reset(rigid: Any, situation: str) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    rig.run(3)
    SITUATIONS[situation](rig)
    was_powered = rig.supervisor.powered
    rig.button.down = True
    outcome = rig.cycle()
    assert outcome.safety_state is SafetyState.CAT1
    assert rig.causes()[-1] == "e-stop"
    assert rig.hand.mode == ("brake" if was_powered else "off")
    rig.button.down = False
    rests_s = 3.2 if situation == "compliant" else 0.5  # the load that made it yield may have been a spasm
    rig.hand.corrupt = lambda state: state
    assert rig.run(round(rests_s / rigid.PERIOD_S)).safety_state is SafetyState.CAT1
    assert rig.hand.mode == "off"
