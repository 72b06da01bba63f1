"""The motion process moves a device in a third process and brakes it, whatever becomes of the app."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robot_iface.adapters.device_file import FOLDER_VARIABLE

StandIn = Callable[..., tuple[Any, Any]]


@pytest.mark.parametrize("fate", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_a_lost_app_is_braked_for_before_the_device_helps_itself(
    fate: signal.Signals,
    stand_in: StandIn,
    processes: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    device, hand = stand_in(watchdog_s=2.0)
    name = f"ros2:{device.name}"
    app = processes("clinic.py", device=name, confirmed=name)
    app.wait_for("phase", "move")
    hand.wait_for("event", "on by command")
    app.process.send_signal(fate)
    off = hand.wait_for("event", "off by command")
    assert off["speed_deg_s"] < 5.0
    assert "braked by watchdog" not in [line.get("event") for line in hand.lines]


def test_a_device_that_nobody_has_confirmed_does_not_move(
    stand_in: StandIn, processes: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    device, hand = stand_in()
    app = processes("clinic.py", device=f"ros2:{device.name}", confirmed="ros2:other")
    assert "confirmed by its own name" in app.wait_for("refused")["refused"]
    assert [line["event"] for line in hand.lines] == ["ready"], "it was powered"
