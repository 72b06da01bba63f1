from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.motion import PathPlayer, PathState

PERIOD_S = 1e-3
ACCELERATION, JERK = 2.0, 20.0


def to_end(player: PathPlayer, at_most: int = 100_000) -> list[PathState]:
    states = [player.step()]
    while not states[-1].at_end:
        states.append(player.step())
        assert len(states) < at_most, "never arrived"
    return states


def test_comes_to_rest_at_the_end_and_stays() -> None:
    player = PathPlayer(3.0, PERIOD_S, 0.5)
    states = to_end(player)
    assert states[-1] == PathState(3.0, 0.0, 0.0, True)
    assert [player.step() for _ in range(5)] == [states[-1]] * 5
    assert len(states) * PERIOD_S == pytest.approx(3.0 / 0.5 + 0.35, abs=0.2)
    assert max(state.s_dot for state in states) == pytest.approx(0.5)


COMMANDS = ["pause", "resume", "reverse", "0.05", "0.1", "0.3", "0.55", "1.0"]
commands = st.lists(st.tuples(st.integers(1, 900), st.sampled_from(COMMANDS)), max_size=14)


def obey(player: PathPlayer, command: str) -> None:
    if command in ("pause", "resume", "reverse"):
        getattr(player, command)()
    else:
        player.request_speed(float(command))


def columns(states: list[PathState]) -> np.ndarray:
    """s, s_dot and s_ddot, (3, n)."""
    return np.array([state[:3] for state in states]).T


@given(
    commands=commands,
    speed=st.floats(0.05, 1.0),
    back=st.floats(0.02, 1.0),
    duration=st.floats(0.05, 5.0),
)
@settings(max_examples=150, deadline=None)
def test_any_commands_keep_the_motion_smooth_within_every_bound_and_complete(
    commands: list[tuple[int, str]], speed: float, back: float, duration: float
) -> None:
    """Speed, acceleration and jerk of the coordinate, through pause, resume, reverse and changes of speed."""
    player = PathPlayer(duration, PERIOD_S, speed, back_speed=back)
    states = [PathState(0.0, 0.0, 0.0, False)]
    for ticks, command in commands:
        states.extend(player.step() for _ in range(ticks))
        obey(player, command)
    player.request_speed(1.0)
    player.resume()
    states.extend(to_end(player))
    s, s_dot, s_ddot = columns(states)
    assert s.min() >= 0.0
    assert s.max() <= duration
    assert s_dot.max() <= 1.0 + 1e-9
    assert s_dot.min() >= -back - 1e-9
    assert np.abs(s_ddot).max() <= ACCELERATION + 1e-9
    assert np.abs(np.diff(s_dot)).max() <= ACCELERATION * PERIOD_S + 1e-9
    assert np.abs(np.diff(s_ddot)).max() <= JERK * PERIOD_S + 1e-9
    travelled = 0.5 * (s_dot[1:] + s_dot[:-1]) * PERIOD_S
    assert np.abs(np.diff(s) - travelled).max() < 1e-8, "the coordinate was pushed back into the path"
    assert s[-1] == duration
    assert player.fault == ""


@given(
    commands=st.lists(st.tuples(st.integers(1, 900), st.sampled_from(COMMANDS[:2])), min_size=1, max_size=8)
)
@settings(max_examples=20, deadline=None)
def test_without_a_reverse_it_never_goes_back(commands: list[tuple[int, str]]) -> None:
    player = PathPlayer(2.0, PERIOD_S, 1.0)
    states = [PathState(0.0, 0.0, 0.0, False)]
    for ticks, command in commands:
        obey(player, command)
        states.extend(player.step() for _ in range(ticks))
    s, s_dot, _ = columns(states)
    assert s_dot.min() >= 0.0
    assert np.diff(s).min() >= -1e-12


@given(ticks=st.integers(1, 5000), back=st.floats(0.05, 1.0))
@settings(max_examples=40, deadline=None)
def test_reverse_comes_to_rest_at_the_start_and_waits_for_a_resume(ticks: int, back: float) -> None:
    player = PathPlayer(3.0, PERIOD_S, 0.7, back_speed=back)
    for _ in range(ticks):
        player.step()
    player.reverse()
    assert player.paused
    way = [player.step() for _ in range(round(3.0 / back / PERIOD_S) + 2000)]
    assert way[-1] == PathState(0.0, 0.0, 0.0, False)
    s, s_dot, _ = columns(way)
    turned = int(np.argmax(s_dot <= 0.0))
    assert s_dot[turned:].max() <= 0.0
    assert np.diff(s[turned:]).max() <= 1e-12
    player.resume()
    assert to_end(player)[-1].s == 3.0


def test_the_way_back_is_never_faster_than_the_speed_that_was_asked_for() -> None:
    player = PathPlayer(5.0, PERIOD_S, 0.2, back_speed=1.0)
    for _ in range(8000):
        player.step()
    player.reverse()
    assert columns([player.step() for _ in range(4000)])[1].min() == pytest.approx(-0.2, abs=1e-9)


@given(ticks=st.integers(1, 5000))
@settings(max_examples=40, deadline=None)
def test_a_pause_stops_monotonically_within_the_bound_and_holds(ticks: int) -> None:
    player = PathPlayer(5.0, PERIOD_S, 1.0)
    states = [player.step() for _ in range(ticks)]
    player.pause()
    stopping = [player.step() for _ in range(800)]
    assert stopping[-1].s_dot == 0.0
    assert stopping[-1].s <= 5.0
    speeds = np.array([states[-1].s_dot, *(state.s_dot for state in stopping)])
    top = int(np.argmax(speeds))
    assert np.diff(speeds[top:]).max() <= 1e-12, "the speed fell, but not all the way"
    assert speeds[top] - speeds[0] <= ACCELERATION**2 / (2 * JERK) + 1e-9
    resting = stopping[-1]
    assert [player.step().s for _ in range(20)] == [resting.s] * 20


def test_rewind_begins_anew_and_is_refused_while_moving() -> None:
    player = PathPlayer(1.0, PERIOD_S, 1.0)
    for _ in range(300):
        player.step()
    with pytest.raises(Refused, match="moving"):
        player.rewind()
    first = to_end(player)[-1]
    player.rewind()
    again = to_end(player)
    assert first == again[-1]
    assert again[0].s < 1e-6


@pytest.mark.parametrize("speed", [0.0, 0.04, 1.01, float("nan"), -1.0])
def test_speeds_outside_the_range_are_refused(speed: float) -> None:
    with pytest.raises(Refused, match="path speed"):
        PathPlayer(1.0, PERIOD_S).request_speed(speed)


def test_a_duration_of_nothing_is_refused() -> None:
    with pytest.raises(Refused, match="duration"):
        PathPlayer(0.0, PERIOD_S)


def test_a_generator_that_gives_up_ends_in_a_smooth_stop() -> None:
    """An input that the generator refuses must brake the path, not the process."""
    player = PathPlayer(5.0, PERIOD_S, 1.0)
    states = [player.step() for _ in range(1000)]
    player._input.max_acceleration = [-1.0]
    states.extend(player.step() for _ in range(1000))
    assert player.fault != ""
    assert states[-1].s_dot == 0.0
    speeds = np.array([state.s_dot for state in states])
    assert np.abs(np.diff(speeds)).max() <= ACCELERATION * PERIOD_S * 1.01


@pytest.mark.parametrize("reversing", [False, True])
def test_a_generator_that_gives_up_on_the_way_back_stops_too(reversing: bool) -> None:
    player = PathPlayer(5.0, PERIOD_S, 1.0)
    for _ in range(2000):
        player.step()
    if reversing:
        player.reverse()
        for _ in range(1500):
            player.step()
        assert player.state.s_dot < -0.5
    player._input.max_jerk = [-1.0]
    states = [player.step() for _ in range(1000)]
    assert player.fault != ""
    assert states[-1].s_dot == 0.0
    assert 0.0 <= states[-1].s <= 5.0
    assert np.abs(np.diff(columns(states)[1])).max() <= ACCELERATION * PERIOD_S + 1e-9


def test_a_coordinate_that_is_led_elsewhere_begins_anew() -> None:
    player = PathPlayer(1.0, PERIOD_S, 1.0)
    for _ in range(300):
        player.step()
    player.abandon()
    assert player.state == PathState(0.0, 0.0, 0.0, False)
    assert to_end(player)[-1].s == 1.0
