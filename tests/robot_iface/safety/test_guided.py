"""A guided machine: any order of faults, repairs, resets and enables, against a model of the state table."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.types import SafetyState

WATCHED = {
    "enable": ({"enable_held": False}, SafetyState.HOLD),
    "pain": ({"pain": True}, SafetyState.HOLD),
    "path": ({"path_age_ns": 10**8}, SafetyState.HOLD),
    "operator": ({"operator_age_ns": 2 * 10**9}, SafetyState.HOLD),
    "heartbeat": ({"heartbeat_age_ns": 10**9}, SafetyState.CAT1),
    "overruns": ({"overruns_in_row": 4}, SafetyState.CAT0),
}
READINGS = {
    "load": ({"tau_interaction_nm": 0.5}, SafetyState.COMPLIANT),
    "speed": ({"dq_rad_s": 4.0}, SafetyState.CAT1),
    "sensor": ({"q_second_rad": 0.1}, SafetyState.CAT0),
    "nan": ({"q_rad": np.nan}, SafetyState.CAT0),
}
ALWAYS = {"sensor", "nan", "stop"}
GOOD = {"enable_held": True, "pain": False, "path_age_ns": 0, "operator_age_ns": 0, "heartbeat_age_ns": 0}
GOOD["overruns_in_row"] = 0
FOLLOWING = (SafetyState.RAMP_IN, SafetyState.ACTIVE)

steps = st.lists(
    st.tuples(
        st.sampled_from(["run", "stop", "reset", "enable edge", *WATCHED, *READINGS]),
        st.integers(0, 2),
    ),
    min_size=1,
    max_size=14,
)


def inject(rig: Any, what: str, joint: int) -> SafetyState:
    """Let one fault happen for one tick; returns the state that it asks for."""
    if what == "stop":
        rig.button.down = True
        rig.run(1)
        rig.button.down = False
        return SafetyState.CAT1
    if what in WATCHED:
        watch, state = WATCHED[what]
        rig.run(1, **watch)
        rig.watch = dataclasses.replace(rig.watch, **GOOD)
        return state
    fields, state = READINGS[what]

    def corrupt(reading: Any) -> Any:
        changes = {}
        for name, value in fields.items():
            changes[name] = getattr(reading, name).copy()
            changes[name][joint] += value
        return dataclasses.replace(reading, **changes)

    rig.hand.corrupt = corrupt
    rig.supervisor._previous = None
    rig.run(1)
    rig.hand.corrupt = lambda reading: reading
    rig.supervisor.read(rig.hand.tick * 1_000_000)
    return state


@given(sequence=steps)
@settings(max_examples=120, deadline=None)
def test_the_state_is_always_the_one_of_the_model(rigid: Any, sequence: list[tuple[str, int]]) -> None:
    rig = rigid.Rig(ramp_s=0.01)
    rig.supervisor.start()
    rig.run(2)
    expected = SafetyState.READY
    for what, joint in sequence:
        if what == "run":
            rig.run(12)
            expected = SafetyState.ACTIVE if expected is SafetyState.RAMP_IN else expected
        elif what == "reset":
            rig.supervisor.reset(present=True)
            expected = SafetyState.READY if expected >= SafetyState.HOLD else expected
        elif what == "enable edge":
            expected = enable(rig, expected)
        else:
            asked = inject(rig, what, joint)
            pursuing = SafetyState.RAMP_IN <= expected <= SafetyState.COMPLIANT
            if (pursuing or what in ALWAYS) and asked > expected:
                expected = asked
        assert rig.supervisor.state is expected, (what, joint)
        check_device(rig, expected)


def enable(rig: Any, expected: SafetyState) -> SafetyState:
    """An enable edge works from READY and from nowhere else."""
    try:
        rig.supervisor.enable_edge()
    except Refused:
        assert expected is not SafetyState.READY
        return expected
    assert expected is SafetyState.READY
    return SafetyState.RAMP_IN


def check_device(rig: Any, state: SafetyState) -> None:
    """What the device really does in each state."""
    mode = rig.hand.mode
    if state is SafetyState.CAT0:
        assert mode == "off"
    elif state in (SafetyState.CAT1, SafetyState.READY):
        assert mode in ("brake", "off")
    elif state in FOLLOWING:
        assert mode in ("command", "enabled")
    assert (mode == "off") == (not rig.supervisor.powered)
