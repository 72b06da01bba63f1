"""A run on a device that is another process: it moves, and either side may die without harm."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robot_iface.loop import may_run_in_real_time

STALLS = {"device-stale", "loop-stalled", "overruns"}
"""What a machine that stalls is stopped for; only a test on a machine that does so meets them."""

StandIn = Callable[..., tuple[Any, Any]]


def run(processes: Callable[..., Any], folder: Path, device: Any, **plan: Any) -> Any:
    return processes("app.py", folder=str(folder), device=f"ros2:{device.name}", **plan)


@pytest.mark.parametrize("command", ["effort", "trajectory"])
def test_it_moves_twenty_degrees_and_ends_without_power(
    command: str, stand_in: StandIn, processes: Callable[..., Any], tmp_path: Path
) -> None:
    device, hand = stand_in(command, watchdog_s=0.5)
    for _ in range(3):
        app = run(processes, tmp_path, device)
        end = app.wait_for("end")
        assert hand.wait_for("event", "off by command")
        if end["completed"]:
            break
        assert {line["cause"] for line in app.lines if "cause" in line} <= STALLS
    if not (end["completed"] or may_run_in_real_time()):
        pytest.skip("this machine stalls and permits no real-time priority")
    assert end["completed"]
    assert end["end"] == "READY"
    assert max(end["travel_deg"]) == pytest.approx(20.0, abs=4.0)


def test_a_killed_app_leaves_the_hand_to_its_own_watchdog(
    stand_in: StandIn, processes: Callable[..., Any], tmp_path: Path
) -> None:
    device, hand = stand_in()
    app = run(processes, tmp_path, device, repetitions=20)
    app.wait_for("phase", "move")
    app.kill()
    hand.wait_for("event", "braked by watchdog")
    off = hand.wait_for("event", "off by watchdog")
    assert off["speed_deg_s"] < 5.0
    again = run(processes, tmp_path, device)
    assert again.wait_for("phase"), "the device was not given back"


def test_a_killed_device_is_cut_off_within_three_periods(
    stand_in: StandIn, processes: Callable[..., Any], tmp_path: Path
) -> None:
    device, hand = stand_in(watchdog_s=0.5)
    app = run(processes, tmp_path, device, repetitions=20)
    app.wait_for("phase", "move")
    hand.kill()
    end = app.wait_for("end")
    assert end["end"] == "CAT0"
    assert {line["cause"] for line in app.lines if "cause" in line} <= STALLS
    if "stale_ticks" in end:
        assert end["stale_ticks"] <= 3
    assert not end["completed"]


def test_a_fault_of_the_device_brakes_and_cuts_its_power(
    stand_in: StandIn, processes: Callable[..., Any], tmp_path: Path
) -> None:
    device, _ = stand_in(watchdog_s=0.5, fault="over-current")
    app = run(processes, tmp_path, device)
    assert app.wait_for("cause")["cause"] in {"device-fault over-current", *STALLS}
    assert app.wait_for("end")["end"] in {"CAT1", "CAT0"}


def test_a_worn_hand_that_locks_without_power_is_refused(
    stand_in: StandIn, processes: Callable[..., Any], tmp_path: Path
) -> None:
    device, hand = stand_in(file={"unpowered": "locked"})
    refused = run(processes, tmp_path, device).wait_for("refused")["refused"]
    assert "locked without power" in refused
    assert "quick release" in refused
    assert [line["event"] for line in hand.lines] == ["ready"], "it was powered"
