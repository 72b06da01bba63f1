"""What an event says: joint, value met and bound, of every cause that has them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.types import SafetyState

JOINT = 1
MS = 1_000_000
DEG = float(np.deg2rad(1.0))
PIP_NM = 0.15


def reading(**fields: float) -> Callable[[Any], None]:
    """The device reports this at one joint from now on."""

    def spoil(rig: Any) -> None:
        rig.supervisor._previous = None

        def corrupt(state: Any) -> Any:
            changed = {name: getattr(state, name).copy() for name in fields}
            for name, value in fields.items():
                changed[name][JOINT] = value
            return dataclasses.replace(state, **changed)

        rig.hand.corrupt = corrupt

    return spoil


def device(**fields: Any) -> Callable[[Any], None]:
    return lambda rig: setattr(rig.hand, "corrupt", lambda state: dataclasses.replace(state, **fields))


def push(torque_nm: float) -> Callable[[Any], None]:
    """The law asks for this feed-forward at one joint, and nothing else of it."""

    def spoil(rig: Any) -> None:
        def change(request: Any) -> Any:
            torque = np.zeros(3)
            torque[JOINT] = torque_nm
            return dataclasses.replace(request, tau_ff_nm=torque, stiffness_nm_rad=np.zeros(3))

        rig.supervisor._previous = None if torque_nm > 1.0 else rig.supervisor._previous
        rig.change = change

    return spoil


def watch(**fields: Any) -> Callable[[Any], None]:
    return lambda rig: setattr(rig, "watch", dataclasses.replace(rig.watch, **fields))


def back(rig: Any) -> None:
    rig.hand.tick -= 3


def late(rig: Any) -> None:
    rig.hand.corrupt = lambda state: dataclasses.replace(state, t_ns=state.t_ns - 7 * MS)


def stalled(rig: Any) -> None:
    rig.hand.tick += 70


NAME = "index_pip"
ROWS: list[tuple[str, Callable[[Any], None], str, float, float]] = [
    ("speed-trip", reading(dq_rad_s=-201.0 * DEG), NAME, 201.0 * DEG, 200.0 * DEG),
    ("torque-measured", reading(tau_nm=-1.9), NAME, 1.9, 1.8),
    ("torque-request", push(2.0), NAME, 2.0, 1.8),
    ("torque-step", push(0.07), NAME, 0.07, 0.06),
    ("load-hard", reading(tau_interaction_nm=-0.24), NAME, 0.24, 1.5 * PIP_NM),
    ("clock-backwards", back, "", -2e-3, 0.0),
    ("device-stale", late, "", 7e-3, 2e-3),
    ("loop-stalled", stalled, "", 71e-3, 50e-3),
    ("temperature", device(temperature_c=81.5), "", 81.5, 80.0),
    ("overruns", watch(overruns_in_row=5), "", 5.0, 3.0),
    ("heartbeat-lost", watch(heartbeat_age_ns=300 * MS), "", 0.3, 0.25),
    ("operator-silent", watch(operator_age_ns=1500 * MS), "", 1.5, 1.0),
    ("camera-lost", watch(camera_age_ns=400 * MS), "", 0.4, 0.3),
    ("path-stale", watch(path_age_ns=60 * MS), "", 0.06, 0.05),
    (
        "repetition-time-out",
        watch(repetition_age_ns=9000 * MS, repetition_timeout_ns=8000 * MS),
        "",
        9.0,
        8.0,
    ),
]


@pytest.mark.parametrize(("cause", "spoil", "joint", "value", "bound"), ROWS, ids=[row[0] for row in ROWS])
def test_an_event_names_its_joint_value_and_bound(
    rigid: Any, cause: str, spoil: Callable[[Any], None], joint: str, value: float, bound: float
) -> None:
    rig = rigid.Rig(ramp_s=0.05, stiffness=0.0, multiple=0.1)
    rig.go_active()
    spoil(rig)
    rig.cycle()
    (event,) = rig.events()
    assert (event.cause, event.joint) == (cause, joint)
    assert (event.value, event.bound) == pytest.approx((value, bound), rel=1e-6)


def test_sensors_that_differ_and_a_held_stretch_say_by_how_much(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    rig.hand.corrupt = lambda state: dataclasses.replace(state, q_second_rad=state.q_rad + 6.0 * DEG)
    rig.cycle()
    assert (rig.events()[0].value, rig.events()[0].bound) == pytest.approx((6.0 * DEG, 5.0 * DEG))
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    reading(tau_interaction_nm=0.6 * PIP_NM)(rig)
    rig.run(3001)
    assert (rig.events()[0].cause, rig.events()[0].joint) == ("held-stretch", "")
    assert (rig.events()[0].value, rig.events()[0].bound) == pytest.approx((0.6, 0.5))


@pytest.mark.parametrize(
    ("share", "ticks", "cause", "state"),
    [(1.2, 10, "load", SafetyState.COMPLIANT), (0.6, 3000, "held-stretch", SafetyState.HOLD)],
)
def test_loads_count_from_the_first_tick_after_an_enable_and_not_from_before(
    rigid: Any, share: float, ticks: int, cause: str, state: SafetyState
) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    reading(tau_interaction_nm=share * PIP_NM)(rig)
    rig.run(ticks - 1)
    assert rig.causes() == []
    rig.supervisor.finish()
    rig.run(5)
    rig.supervisor.enable_edge()
    assert rig.ticks_until(state, ticks + 1) == ticks
    assert rig.causes() == [cause]
    event = rig.events()[0]
    assert event.t_ns == rig.states[-1].t_ns


@pytest.mark.parametrize("verb", ["enable", "clear_faults", "close"])
def test_a_device_that_fails_at_a_seldom_used_verb_is_cut_off_and_nothing_is_raised(
    rigid: Any, verb: str, monkeypatch: Any
) -> None:
    rig = rigid.Rig(ramp_s=0.05)

    def fail() -> None:
        raise OSError(5, "Input/output error")

    if verb == "enable":
        rig.supervisor.start()
        rig.run(3)
        monkeypatch.setattr(rig.hand, verb, fail)
        rig.supervisor.enable_edge()
    else:
        rig.go_active()
        rig.run(1, enable_held=False)
        monkeypatch.setattr(rig.hand, verb, fail)
        if verb == "close":
            rig.supervisor.close()
            assert (rig.hand.mode, rig.supervisor.state) == ("off", SafetyState.OFF)
            return
        rig.supervisor.reset(present=True)
    assert rig.cycle().safety_state is SafetyState.CAT0
    assert rig.causes()[-1] == "device-lost Input/output error"
    assert (rig.hand.mode, rig.supervisor.powered) == ("off", False)


def test_a_device_that_cannot_be_opened_is_refused(rigid: Any, monkeypatch: Any) -> None:
    rig = rigid.Rig()

    def fail() -> None:
        raise OSError(19, "No such device")

    monkeypatch.setattr(rig.hand, "open", fail)
    with pytest.raises(Refused, match="No such device"):
        rig.supervisor.start()
    assert rig.supervisor.state is SafetyState.OFF
