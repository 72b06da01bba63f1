from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robot_iface.control import AssistAsNeeded, FeedForward, learning_share, nominal_gains
from robot_iface.control.assist import SLOW_RAD_S
from robot_iface.safety import shipped_limits
from robot_iface.types import Limits

LIMIT = np.array([0.25, 0.15])
MIDDLE = np.full(2, 0.5)
DURATION_S = 4.0
SPEED = 0.5
PERIOD_S = 1e-3


def limits(tau_nm: object = LIMIT) -> Limits:
    wide = shipped_limits(("index_mcp_flexion", "index_pip"), np.zeros(2), np.ones(2))
    return replace(wide, tau_interaction_nm=np.zeros(2) + tau_nm)


def plant_repetition(learner: FeedForward, gain: float, joint_stiffness: float, load: float = 0.3) -> float:
    """One repetition of a hand that is a spring: K e + u = k q. Returns the RMS error."""
    squares = []
    for s in np.arange(0.0, DURATION_S, SPEED * 4 * PERIOD_S):
        target = 0.15 * (1.0 - np.cos(2 * np.pi * s / DURATION_S)) * np.ones(2)
        error = (joint_stiffness * target - learner.torque(s, MIDDLE)) / (gain + joint_stiffness)
        learner.observe(float(s), error, load)
        squares.append(error**2)
    learner.learn(np.full(2, gain), SPEED)
    return float(np.sqrt(np.mean(squares)))


def test_learning_halves_the_error_of_a_stiff_linear_hand_each_repetition() -> None:
    """Contraction 1 - 0.8 K / (K + k): 0.491 for K = 0.9 and k = 0.515, as measured on the real model."""
    learner = FeedForward(DURATION_S, limits(1.0), 1.0)
    errors = [plant_repetition(learner, 0.9, 0.515) for _ in range(7)]
    ratios = np.array(errors[1:]) / np.array(errors[:-1])
    assert np.allclose(ratios[:4], 1 - 0.8 * 0.9 / (0.9 + 0.515), atol=0.03)
    assert errors[6] < 0.05 * errors[0]


def test_forgetting_keeps_an_error_and_so_work_for_the_patient() -> None:
    full, forgetful = (FeedForward(DURATION_S, limits(LIMIT * 9), f) for f in (1.0, 0.8))
    kept = [plant_repetition(forgetful, 0.9, 0.3) for _ in range(12)][-1]
    assert kept > 10 * [plant_repetition(full, 0.9, 0.3) for _ in range(12)][-1]


def test_feed_forward_never_exceeds_half_the_interaction_limit() -> None:
    learner = FeedForward(DURATION_S, limits(), 1.0)
    for _ in range(10):
        plant_repetition(learner, 4.0, 5.0)
    peak = np.max([np.abs(learner.torque(s, MIDDLE)) for s in np.linspace(0, DURATION_S, 999)], axis=0)
    assert np.allclose(peak, 0.5 * LIMIT)


@pytest.mark.parametrize(("load", "discard"), [(0.81, False), (0.3, True)])
def test_all_is_thrown_away_after_a_high_load_or_a_reversal(load: float, discard: bool) -> None:
    learner = FeedForward(DURATION_S, limits(), 1.0)
    plant_repetition(learner, 0.9, 0.3)
    assert np.abs(learner.torque(DURATION_S / 2, MIDDLE)).max() > 0.01
    learner.observe(1.0, np.full(2, 0.1), load)
    assert learner.learn(np.full(2, 0.9), SPEED, discard=discard) is False
    assert np.abs([learner.torque(s, MIDDLE) for s in np.linspace(0, DURATION_S, 99)]).max() == 0.0


def test_what_is_learnt_belongs_to_the_place_not_to_the_speed() -> None:
    """An error that is met at one place only is answered there, whether it was played fast or slowly."""
    peaks = []
    for speed in (0.25, 1.0):
        learner = FeedForward(DURATION_S, limits(), 1.0)
        for s in np.arange(0.0, DURATION_S, speed * PERIOD_S):
            learner.observe(float(s), 0.1 * np.exp(-((s - 2.5) ** 2) / 0.1) * np.ones(2), 0.2)
        learner.learn(np.ones(2), speed)
        peaks.append(max(np.linspace(0, DURATION_S, 801), key=lambda s: float(learner.torque(s, MIDDLE)[0])))
    assert peaks == pytest.approx([2.5, 2.5], abs=0.02)


def test_an_unmoved_repetition_changes_nothing() -> None:
    learner = FeedForward(DURATION_S, limits(), 1.0)
    assert learner.learn(np.ones(2), SPEED) is True
    assert np.abs(learner.torque(1.0, MIDDLE)).max() == 0.0


PLACES_S = np.linspace(0.0, DURATION_S, 401)


def learnt_from(errors: np.ndarray, headings: np.ndarray | None, q: np.ndarray = MIDDLE) -> np.ndarray:
    """What one repetition with these errors, (401, J) over the path, teaches, (401, J)."""
    learner = FeedForward(DURATION_S, limits(), 1.0, headings)
    for place_s, error in zip(PLACES_S, errors, strict=True):
        learner.observe(float(place_s), error, 0.2)
    learner.learn(np.ones(2), SPEED)
    return np.array([learner.torque(float(place_s), q) for place_s in PLACES_S])


CLOSE_THEN_OPEN = np.where(PLACES_S < 2.0, 1.0, -1.0)[:, None] * [1.0, 0.5]


@pytest.mark.parametrize("ahead_rad", [0.02, 0.1, 0.4])
def test_a_patient_who_is_ahead_teaches_nothing_and_passive_learning_does_not_mind(ahead_rad: float) -> None:
    """Also beyond the 15 degrees at which the spring comes back."""
    errors = -ahead_rad * np.sign(CLOSE_THEN_OPEN)
    assert np.abs(learnt_from(errors, CLOSE_THEN_OPEN)).max() == 0.0
    assert np.abs(learnt_from(errors, None)).max() > 0.01


def test_one_joint_ahead_teaches_nothing_about_itself_though_the_others_lag() -> None:
    errors = np.sign(CLOSE_THEN_OPEN) * [0.1, -0.1]
    tau = learnt_from(errors, CLOSE_THEN_OPEN)
    assert np.abs(tau[:, 1]).max() == 0.0
    assert tau[100, 0] > 0.05
    assert tau[300, 0] < -0.05


def test_the_last_heading_holds_where_the_path_has_come_to_rest() -> None:
    headings = CLOSE_THEN_OPEN * (PLACES_S < 3.0)[:, None]
    errors = (PLACES_S > 3.0)[:, None] * [0.1, 0.1]
    assert np.abs(learnt_from(errors, headings)).max() == 0.0, "too open at the end of opening is ahead"
    assert learnt_from(-errors, headings)[330].max() < -0.05


def test_errors_across_the_path_are_learnt_either_way() -> None:
    still = CLOSE_THEN_OPEN * [1.0, 0.0]
    for sign in (-1.0, 1.0):
        tau = learnt_from(np.full((401, 2), [0.0, 0.1 * sign]), still)
        assert tau[200, 1] * sign > 0.05


def test_assistive_feed_forward_is_zero_at_both_ends_and_rises_gently() -> None:
    tau = learnt_from(0.4 * np.sign(CLOSE_THEN_OPEN), CLOSE_THEN_OPEN)
    assert np.all(tau[[0, -1]] == 0.0)
    assert np.allclose(np.abs(tau[[100, 300]]), 0.5 * LIMIT)
    per_second = np.abs(np.diff(tau[:40], axis=0)).max() / (PLACES_S[1] - PLACES_S[0])
    assert per_second <= 1.51 * 0.125 / 0.4
    passive = learnt_from(np.full((401, 2), 0.4), None)
    assert np.allclose(passive[[0, -1]], 0.5 * LIMIT), "passive it bears the hand at the ends, too"


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_no_joint_is_pushed_to_an_end_of_its_range_that_it_is_near(sign: float) -> None:
    errors = np.full((401, 2), 0.4 * sign)
    end, inward = (1.0, -1.0) if sign > 0 else (0.0, 1.0)
    shares = []
    for degrees in (-3.0, 0.0, 1.0, 2.0, 3.0, 9.0):
        tau = learnt_from(errors, None, np.full(2, end + inward * np.deg2rad(degrees)))
        shares.append(float(tau[200, 0]) / (0.5 * LIMIT[0] * sign))
    assert shares == pytest.approx([0.0, 0.0, 1 / 3, 2 / 3, 1.0, 1.0], abs=1e-9)
    away = learnt_from(errors, None, np.full(2, 1.0 - end))
    assert np.allclose(np.abs(away[200]), 0.5 * LIMIT), "away from an end it may push"


def test_what_was_learnt_can_be_forgotten_at_once() -> None:
    learner = FeedForward(DURATION_S, limits(), 1.0)
    plant_repetition(learner, 0.9, 0.3)
    learner.forget()
    assert np.abs([learner.torque(s, MIDDLE) for s in PLACES_S]).max() == 0.0


NAMES = ("index_mcp_flexion", "index_pip", "ring_pip")


def move(
    assist: AssistAsNeeded,
    direction: float,
    error: object,
    dq: object,
    seconds: float = 1.0,
    rise: float = 0.0,
) -> None:
    desired = np.full(3, direction * 0.5)
    for tick in range(round(seconds / PERIOD_S)):
        assist.multiple(desired)
        push = direction * (0.05 + rise * tick * PERIOD_S)
        assist.observe(desired, np.zeros(3) + error, np.zeros(3) + dq, np.full(3, push))


def test_rule_of_adaptation_by_digit_and_direction() -> None:
    """K' = 0.8 K + 8 (e - 3 deg), only for the digit and direction that was behind."""
    assist = AssistAsNeeded(NAMES, 1.0, PERIOD_S)
    behind = np.deg2rad(9.0)
    move(assist, -1.0, np.array([-behind, -behind / 9, 0.0]), -0.5)
    move(assist, 1.0, 0.0, 0.5)
    assist.finish_repetition()
    extension, flexion = assist.by_direction()
    raised = 0.8 + 8 * (behind - np.deg2rad(3.0))
    assert np.allclose(extension, [raised, raised, 0.8], atol=2e-3)
    assert np.allclose(flexion, 0.8)


def test_assistance_is_bounded_and_falls_as_ability_grows() -> None:
    assist = AssistAsNeeded(NAMES, 9.0, PERIOD_S)
    assert assist.by_direction().max() == 4.0
    history = []
    for _ in range(25):
        move(assist, 1.0, 0.0, 0.5, seconds=0.05)
        assist.finish_repetition()
        history.append(float(assist.by_direction()[1, 0]))
    assert np.all(np.diff(history) <= 0)
    assert history[-1] == pytest.approx(0.1)


def test_running_ahead_is_not_an_error() -> None:
    assist = AssistAsNeeded(NAMES, 1.0, PERIOD_S)
    move(assist, 1.0, -0.5, 0.5)
    assist.finish_repetition()
    extension, flexion = assist.by_direction()
    assert np.allclose(flexion, 0.8)
    assert np.allclose(extension, 1.0), "where nothing moved nothing was learnt"


@pytest.mark.parametrize("cause", ["blocked", "reversed", "painful"])
def test_blocked_reversed_or_painful_repetitions_never_raise(cause: str) -> None:
    assist = AssistAsNeeded(NAMES, 1.0, PERIOD_S)
    blocked = cause == "blocked"
    move(assist, -1.0, -0.4, 0.0 if blocked else -0.5, rise=0.1 if blocked else 0.0)
    assert assist.blocked() == (("index", "ring") if blocked else ())
    assist.finish_repetition(reversed_on_load=cause == "reversed", painful=cause == "painful")
    assert assist.by_direction().max() <= 1.0
    assert np.all(assist.by_direction()[0] == 1.0)


def test_standing_still_without_rising_torque_is_weakness_not_a_block() -> None:
    assist = AssistAsNeeded(NAMES, 1.0, PERIOD_S)
    move(assist, -1.0, -0.4, -0.5 * SLOW_RAD_S, rise=0.0)
    assert assist.blocked() == ()
    assist.finish_repetition()
    assert assist.by_direction()[0].min() > 1.0


def test_a_change_of_direction_never_jumps() -> None:
    assist = AssistAsNeeded(NAMES, 1.0, PERIOD_S)
    move(assist, -1.0, -0.4, -0.5)
    assist.finish_repetition()
    rows = [assist.multiple(np.full(3, sign * 0.5)) for sign in (1.0, -1.0, 1.0) for _ in range(2000)]
    assert np.abs(np.diff(rows, axis=0)).max() <= 3.0 * PERIOD_S + 1e-12
    assert np.ptp(rows) > 1.0


def soft_spring_errors(share: float) -> list[float]:
    """RMS errors of a hand that is held by a tenth of the stiffness that learning is told."""
    learner, errors = FeedForward(DURATION_S, limits(1.0), 1.0, None, share), []
    for _ in range(12):
        squares = []
        for s in np.arange(0.0, DURATION_S, SPEED * 4 * PERIOD_S):
            target = 0.15 * (1.0 - np.cos(2 * np.pi * s / DURATION_S)) * np.ones(2)
            error = (0.04 * target - learner.torque(s, MIDDLE)) / (0.09 + 0.04)
            learner.observe(float(s), error, 0.3)
            squares.append(error**2)
        learner.learn(np.full(2, 0.9), SPEED)
        errors.append(float(np.sqrt(np.mean(squares))))
    return errors


def test_learning_that_makes_it_worse_is_thrown_away_and_slowed() -> None:
    """Without the guard each error would be four and a half times the last."""
    errors = np.array(soft_spring_errors(1.0))
    assert errors.max() < 4.6 * errors[0]
    assert errors[-1] < 0.5 * errors[0]


def test_with_its_share_of_the_stiffness_learning_converges_from_the_first_repetition() -> None:
    errors = np.array(soft_spring_errors(0.1))
    assert np.all(np.diff(errors[:6]) < 0.0)
    assert errors[6] < 0.05 * errors[0]
    names = ("index_mcp_flexion", "index_pip")
    least = learning_share(names, "fingertip") * nominal_gains(names, "fingertip").stiffness_nm_rad
    assert np.allclose(least, 0.03)
    assert np.all(learning_share(names, "joint") == 1.0)
