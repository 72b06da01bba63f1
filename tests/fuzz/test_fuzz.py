"""Faults, orders and people's acts at random over the whole motion core: the short form of ``make fuzz``."""

from __future__ import annotations

from pathlib import Path

import pytest

from robot_iface.safety.drive import Drive
from robot_iface.types import SafetyState
from tests.fuzz.episode import Played, play

SEEDS = (0, 7, 8, 10, 11, 25)
"""23,000 control ticks in all four modes, on both devices; ``make fuzz`` plays a million."""


@pytest.fixture(scope="module")
def reached() -> dict[int, Played]:
    """The episodes as they are played."""
    return {}


@pytest.mark.parametrize("seed", SEEDS)
def test_whatever_happens_every_tick_is_as_the_table_of_faults_has_it(
    seed: int, reached: dict[int, Played], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # the physics engine writes its warnings where it runs
    reached[seed] = played = play(seed)
    assert played.failures == ()
    assert played.digest


def test_the_episodes_have_reached_every_state(reached: dict[int, Played]) -> None:
    if len(reached) < len(SEEDS):
        pytest.skip("needs all episodes of this module")
    states = {name for played in reached.values() for name in played.states}
    assert states == {state.name for state in SafetyState} - {"OFF"}
    assert sum(played.ticks for played in reached.values()) > 20_000


def test_the_same_seed_is_the_same_episode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first, again = play(SEEDS[-1]), play(SEEDS[-1])
    assert first.digest
    assert (first.digest, first.ticks, first.causes) == (again.digest, again.ticks, again.causes)


def test_the_judge_sees_a_supervisor_that_does_not_brake(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A judge that finds nothing may be blind: with the brake taken out it must speak."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Drive, "_brake", lambda self, damping_nms_rad: None)
    played = play(7)
    assert any("in mode command in CAT1" in failure for failure in played.failures)
