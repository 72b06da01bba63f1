"""Assistance from session to session, and the hand that answers help with resistance."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.control import AssistAsNeeded, thesis_gains
from robot_iface.errors import Refused

NAMES = ("index_mcp_flexion", "index_pip", "ring_pip")
PERIOD_S = 1e-3
THESIS = thesis_gains(NAMES).stiffness_nm_rad
SPEED_RAD_S = 0.5


def repetition(assist: AssistAsNeeded, hand_nm_rad: object, way: float = 1.0, seconds: float = 1.0) -> None:
    """One quasi-static repetition: a hand that is a spring lags behind the robot's spring."""
    hand = np.zeros(3) + hand_nm_rad
    desired = np.full(3, way * SPEED_RAD_S)
    row = 1 if way > 0.0 else 0
    for tick in range(round(seconds / PERIOD_S)):
        assist.multiple(desired)
        stiffness = THESIS * assist.by_direction()[row]
        goal = 0.5 * way * tick * PERIOD_S
        q = goal * stiffness / (stiffness + hand)
        speed = desired * stiffness / (stiffness + hand)
        assist.observe(desired, goal - q, speed, hand * q)


def test_assistance_goes_on_where_the_last_session_ended() -> None:
    assist = AssistAsNeeded(NAMES, 3.0, PERIOD_S)
    repetition(assist, 0.4)
    assist.finish_repetition()
    remembered = assist.by_digit()
    assert [len(row) for row in remembered] == [5, 5]
    later = AssistAsNeeded(NAMES, 1.0, PERIOD_S, by_digit=remembered)
    assert np.array_equal(later.by_direction(), assist.by_direction())
    assert later.by_digit() == remembered
    first = later.multiple(np.full(3, SPEED_RAD_S))
    assert np.allclose(first, later.by_direction()[1], atol=3.0 * PERIOD_S)


def test_what_is_remembered_is_kept_in_its_range_and_form() -> None:
    wild = ((0.0, 9.0, 1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0, 1.0))
    assert AssistAsNeeded(NAMES, 1.0, PERIOD_S, by_digit=wild).by_digit()[0][:2] == (0.1, 4.0)
    with pytest.raises(Refused, match="assistance is of another form"):
        AssistAsNeeded(NAMES, 1.0, PERIOD_S, by_digit=((1.0,), (1.0,)))


def history(hand: float, repetitions: int) -> tuple[list[float], list[tuple[str, ...]]]:
    """Flexion multiple of the index finger, and who is to relax, after each repetition."""
    assist = AssistAsNeeded(NAMES, 0.5, PERIOD_S)
    multiples, relax = [], []
    for _ in range(repetitions):
        repetition(assist, hand)
        assist.finish_repetition()
        multiples.append(float(assist.by_direction()[1, 0]))
        relax.append(assist.cue_relax)
    return multiples, relax


def test_a_stiff_hand_that_answers_help_with_load_is_helped_less_and_told_to_relax() -> None:
    multiples, relax = history(0.6, 4)
    assert multiples[0] > 0.55, "first it lags and is helped more"
    assert relax[0] == ()
    assert set(relax[1]) == {"index", "ring"}
    assert multiples[1] <= 0.5, "help goes back to what it was before it was raised"
    assert max(multiples[1:]) <= 0.5, "and stays there while the load is as high"


def test_a_weak_hand_is_helped_as_far_as_it_needs_and_never_told_to_relax() -> None:
    multiples, relax = history(0.1, 8)
    assert all(digits == () for digits in relax)
    assert max(multiples) > 0.5


def test_help_may_rise_again_once_the_hand_has_relaxed() -> None:
    assist = AssistAsNeeded(NAMES, 0.5, PERIOD_S)
    for _ in range(2):
        repetition(assist, 0.6)
        assist.finish_repetition()
    assert assist.cue_relax
    assert assist.by_direction()[1].max() <= 0.5
    repetition(assist, 0.1)
    assist.finish_repetition()
    assert assist.cue_relax == ()
    assert assist.by_direction()[1, 0] > 0.6


def test_only_the_direction_that_opposes_is_lowered() -> None:
    assist = AssistAsNeeded(NAMES, 0.5, PERIOD_S)
    for _ in range(2):
        repetition(assist, 0.6, way=-1.0)
        repetition(assist, 0.15, way=1.0)
        assist.finish_repetition()
    extension, flexion = assist.by_direction()
    assert extension.max() <= 0.5
    assert flexion.max() > 0.5


def test_a_tiny_torque_is_no_opposition() -> None:
    assist = AssistAsNeeded(NAMES, 0.1, PERIOD_S)
    for _ in range(4):
        repetition(assist, 0.05, seconds=0.6)
        assist.finish_repetition()
        assert assist.cue_relax == ()
