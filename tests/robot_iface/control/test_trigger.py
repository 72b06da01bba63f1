from __future__ import annotations

import numpy as np
import pytest

from robot_iface.control import Start, StartTrigger

PERIOD_S = 1e-3
OPENING = np.array([-1.0, -1.0, 0.0])


def watch(q_of_t, timeout_s: float = 8.0, direction=OPENING, seed: int | None = None) -> tuple[Start, float]:
    """Run until a decision; time is counted from the cue (after 1 s of settling)."""
    trigger = StartTrigger(direction, PERIOD_S, timeout_s)
    noise = None if seed is None else np.random.default_rng(seed)
    for tick in range(12_000):
        t_s = tick * PERIOD_S - 1.0
        q = np.asarray(q_of_t(t_s), dtype=np.float64)
        if noise is not None:
            q = q + noise.normal(0.0, np.deg2rad(0.05), 3)
        start = trigger.update(q)
        if start >= Start.PATIENT:
            assert trigger.update(q) is start, "a decision is final"
            return start, t_s
        assert start is (Start.SETTLING if tick + 1 < 1000 else Start.CUED)
    raise AssertionError("no decision")


def ramp(rate_deg_s: float, from_s: float, columns=(1.0, 1.0, 0.0)):
    return lambda t_s: 0.6 + np.deg2rad(rate_deg_s) * max(t_s - from_s, 0.0) * np.array(columns)


def test_opening_after_the_cue_is_the_patients_start() -> None:
    start, at_s = watch(ramp(-10.0, 0.5), seed=1)
    assert start is Start.PATIENT
    assert 0.8 < at_s < 1.2, "half a degree and 300 ms"


@pytest.mark.parametrize(
    "motion",
    [
        lambda t_s: np.full(3, 0.6),
        ramp(10.0, 0.5),
        ramp(-10.0, 0.5, (0.0, 0.0, 1.0)),
        lambda t_s: 0.6 + np.deg2rad(0.4) * np.sin(2 * np.pi * 5.0 * t_s) * np.ones(3),
        ramp(-0.5, -1.0),
        lambda t_s: 0.6 - np.deg2rad(2.0) * (0.4 < t_s < 0.5) * np.ones(3),
        ramp(-10.0, 5.5),
    ],
    ids=["rest", "wrong direction", "other digit", "tremor", "drift", "twitch of 100 ms", "after 5 s"],
)
def test_no_start_without_intention(motion) -> None:
    """Then the robot helps at the time-out, and the repetition counts as started by the robot."""
    assert watch(motion, seed=2) == (Start.ROBOT, pytest.approx(8.0, abs=0.002))


def test_a_hand_that_drifts_while_settling_has_its_own_baseline() -> None:
    """Settled anywhere: only movement against the baseline counts."""

    def shift(t_s: float) -> np.ndarray:
        return 0.6 - np.deg2rad(8.0) * min(max(t_s + 1.0, 0.0), 0.3) * np.ones(3)

    assert watch(shift)[0] is Start.ROBOT


def test_movement_before_the_window_does_not_count_until_the_window() -> None:
    start, at_s = watch(ramp(-10.0, 0.0))
    assert start is Start.PATIENT
    assert at_s >= 0.3 + 0.2 - 0.002


def test_the_time_out_is_the_prescribed_one() -> None:
    assert watch(lambda t_s: np.full(3, 0.6), timeout_s=2.0) == (Start.ROBOT, pytest.approx(2.0, abs=0.002))


def test_rearming_begins_anew() -> None:
    trigger = StartTrigger(OPENING, PERIOD_S, 1.0)
    for _ in range(3000):
        trigger.update(np.full(3, 0.6))
    assert trigger.state is Start.ROBOT
    trigger.rearm()
    assert trigger.update(np.full(3, 0.9)) is Start.SETTLING
