"""A hand on its way, and loads that come and go."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

OPENING, CLOSING = np.deg2rad(-15.0), np.deg2rad(30.0)


def gliding(rigid: Any, speed_rad_s: float = OPENING, **hand: Any) -> Any:
    """A hand on its way, at full torque."""
    rig = rigid.Rig(ramp_s=0.05, **({"q_rad": 0.8, "rest_rad": 0.8, "stiffness": 0.02} | hand))
    rig.go_active()
    rig.glide(speed_rad_s, 0.5)
    rig.speed = np.zeros(3) + speed_rad_s
    return rig


def load(rig: Any, share: float, joint: int = 0) -> None:
    """From now on the device reports this interaction torque at a joint, as a share of its limit."""

    def corrupt(state: Any) -> Any:
        torque = state.tau_interaction_nm.copy()
        torque[joint] = share * rig.limits.tau_interaction_nm[joint]
        return dataclasses.replace(state, tau_interaction_nm=torque)

    rig.hand.corrupt = corrupt


def unload(rig: Any) -> None:
    rig.hand.corrupt = lambda state: state


def until_reversal(rig: Any, at_most: int = 30) -> int:
    for tick in range(1, at_most + 1):
        if rig.cycle().reversing:
            return tick
    raise AssertionError(f"no reversal: {rig.causes()}")
