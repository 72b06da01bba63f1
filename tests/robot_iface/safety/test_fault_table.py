"""The table of faults itself: every row, the state that it leads to, and its deadline in ticks of 1 ms."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.types import SafetyState

CAT0, CAT1, HOLD, COMPLIANT = SafetyState.CAT0, SafetyState.CAT1, SafetyState.HOLD, SafetyState.COMPLIANT
MS = 1_000_000


def reading(joint: int = 1, **fields: float) -> Callable[[Any], None]:
    """The device reports so much more at one joint from now on."""

    def spoil(rig: Any) -> None:
        def corrupt(state: Any) -> Any:
            changed = {name: getattr(state, name).copy() for name in fields}
            for name, value in fields.items():
                changed[name][joint] += value
            return dataclasses.replace(state, **changed)

        rig.hand.corrupt = corrupt

    return spoil


def device(**fields: Any) -> Callable[[Any], None]:
    """The device reports this from now on."""
    return lambda rig: setattr(rig.hand, "corrupt", lambda state: dataclasses.replace(state, **fields))


def request(joint: int = 1, **fields: float) -> Callable[[Any], None]:
    """The control law asks for so much more at one joint from now on."""

    def spoil(rig: Any) -> None:
        def change(command: Any) -> Any:
            changed = {name: getattr(command, name).copy() for name in fields}
            for name, value in fields.items():
                changed[name][joint] += value
            return dataclasses.replace(command, **changed)

        rig.change = change

    return spoil


def watch(**fields: Any) -> Callable[[Any], None]:
    """The loop reports this from now on."""
    return lambda rig: setattr(rig, "watch", dataclasses.replace(rig.watch, **fields))


def ageing(field: str) -> Callable[[Any], None]:
    """Something falls silent: its age grows with every tick from now on."""

    def spoil(rig: Any) -> None:
        born, corrupt = rig.hand.tick, rig.hand.corrupt

        def grow(state: Any) -> Any:
            rig.watch = dataclasses.replace(rig.watch, **{field: (rig.hand.tick - born) * MS})
            return corrupt(state)

        rig.hand.corrupt = grow

    return spoil


def press(rig: Any) -> None:
    rig.button.down = True


def freeze(rig: Any) -> None:
    last = rig.states[-1]
    rig.hand.corrupt = lambda state: last


def stand_still(rig: Any) -> None:
    rig.hand.tick += 52


def go_out_of_range(rig: Any) -> None:
    rig.hand.q[1] = rig.limits.q_max_rad[1] + np.deg2rad(2.1)
    rig.supervisor._previous, rig.supervisor._continued = None, False


def too_fast(rig: Any) -> None:
    reading(dq_rad_s=np.deg2rad(-201.0))(rig)
    rig.supervisor._previous = None


def too_strong(rig: Any) -> None:
    reading(dq_rad_s=np.deg2rad(199.0))(rig)
    rig.supervisor._previous = None


def hold_a_stretch(rig: Any) -> None:
    reading(tau_interaction_nm=-0.6 * 0.15)(rig)
    rig.speed = np.zeros(3)


def clock_back(rig: Any) -> None:
    rig.hand.tick -= 2


def clock_ahead(rig: Any) -> None:
    rig.hand.corrupt = lambda state: dataclasses.replace(state, t_ns=state.t_ns - 3 * MS)


NAN = float("nan")
INF = float("inf")
ROWS: list[tuple[str, Callable[[Any], None], SafetyState, int]] = [
    ("e-stop", press, CAT1, 1),
    ("NaN in the state", reading(dq_rad_s=NAN), CAT0, 1),
    ("infinite state", reading(tau_interaction_nm=INF), CAT0, 1),
    ("NaN in the command", request(q_rad=NAN), CAT0, 1),
    ("infinite command", request(tau_ff_nm=-INF), CAT0, 1),
    ("sensors differ > 5 deg", reading(q_second_rad=np.deg2rad(5.1)), CAT0, 1),
    ("> 3 overruns in a row", watch(overruns_in_row=4), CAT0, 1),
    ("joint outside by > 2 deg", go_out_of_range, CAT1, 1),
    ("speed over trip", too_fast, CAT1, 1),
    ("commanded torque > 3x cap", request(tau_ff_nm=1.81), CAT1, 1),
    ("torque step over rate", request(tau_ff_nm=0.061), CAT1, 1),
    ("power over limit", too_strong, CAT1, 1),
    ("interaction over limit, with the motion", reading(tau_interaction_nm=0.18), COMPLIANT, 30),
    ("interaction > 1.5x", reading(tau_interaction_nm=-0.24), COMPLIANT, 1),
    ("heartbeat lost", ageing("heartbeat_age_ns"), CAT1, 252),
    ("operator silent or stale picture", ageing("operator_age_ns"), HOLD, 1002),
    ("device state stale", freeze, CAT0, 3),
    ("device clock behind", clock_ahead, CAT0, 1),
    ("set-point or path stale", ageing("path_age_ns"), HOLD, 52),
    ("loop stood still", stand_still, HOLD, 1),
    ("camera lost", ageing("camera_age_ns"), HOLD, 302),
    ("repetition over its time", watch(repetition_age_ns=2, repetition_timeout_ns=1), HOLD, 1),
    ("load > 50 % for 3 s at rest", hold_a_stretch, HOLD, 3300),
    ("enable released", watch(enable_held=False), HOLD, 1),
    ("over-temperature", device(temperature_c=80.1), CAT1, 1),
    ("device fault", device(faults=("overload",)), CAT1, 1),
    ("pain", watch(pain=True), HOLD, 1),
    ("clock goes backwards", clock_back, CAT0, 1),
]


@pytest.mark.parametrize(("row", "spoil", "state", "deadline_ticks"), ROWS, ids=[row[0] for row in ROWS])
def test_every_row_leads_to_its_state_in_time(
    rigid: Any, row: str, spoil: Callable[[Any], None], state: SafetyState, deadline_ticks: int
) -> None:
    """On an opening hand in its full torque. The most that is entered is that state, with one event."""
    limits = rigid.Rig().limits
    if spoil is too_strong:
        limits = dataclasses.replace(limits, power_w=0.01)
    rig = rigid.Rig(ramp_s=0.05, limits=limits, stiffness=0.1)
    rig.go_active()
    rig.glide(-0.2, 0.6)
    rig.speed = np.full(3, -0.2)
    assert rig.events() == []
    spoil(rig)
    rig.ticks_until(state, deadline_ticks)
    assert len(rig.events()) == 1
    mode = {CAT0: "off", CAT1: "brake"}.get(state, "command")
    assert rig.hand.mode == mode


def test_interaction_over_the_limit_against_the_motion_reverses_within_30_ms(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05, stiffness=0.1)
    rig.go_active()
    rig.glide(-0.2, 0.6)
    rig.speed = np.full(3, -0.2)
    reading(tau_interaction_nm=-0.17)(rig)
    rig.run(30)
    assert rig.causes() == ["reversal"]
    assert rig.outcomes[-1].reversing
    assert rig.supervisor.state is SafetyState.ACTIVE


@pytest.mark.parametrize(("ahead_ms", "trips"), [(49, False), (51, True)])
def test_a_reading_from_the_future_is_not_trusted(rigid: Any, ahead_ms: int, trips: bool) -> None:
    """By its age it would never be stale."""
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    rig.hand.corrupt = lambda state: dataclasses.replace(state, t_ns=state.t_ns + ahead_ms * MS)
    assert (rig.cycle().safety_state is CAT0) == trips
    assert rig.causes() == (["device-stale"] if trips else [])


def test_readings_that_overtake_each_other_count_as_old(rigid: Any) -> None:
    """Two in a row are borne, three are not; a late one that is overtaken is no new one."""
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    for back, state in ((3, SafetyState.ACTIVE), (5, SafetyState.ACTIVE), (4, CAT0)):
        rig.hand.corrupt = lambda reading, back=back: dataclasses.replace(reading, seq=reading.seq - back)
        assert rig.cycle().safety_state is state
    assert rig.causes() == ["device-stale"]


def test_a_clock_that_goes_backwards_is_not_trusted_even_without_power(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    rig.run(5)
    clock_back(rig)
    assert rig.cycle().safety_state is CAT0
    assert rig.causes() == ["clock-backwards"]
