"""The advice names everything that a real hand needs and tells what is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robot_iface.adapters import advice
from robot_iface.adapters.advice import real_device_advice


def test_it_names_every_need(tmp_path: Path) -> None:
    text = "\n".join(real_device_advice(tmp_path))
    for word in (
        *("ros2 extra", "device file", "SCHED_FIFO", "stop that cuts motor power", "without power"),
        *("quick release", "by name", "watchdog", "none so far"),
    ):
        assert word in text
    assert all(line.endswith(".") for line in real_device_advice(tmp_path))


def test_it_tells_what_is_there(
    write_device: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = write_device().name
    assert f"ros2:{name}" in real_device_advice(tmp_path)[1]
    monkeypatch.setattr(advice, "may_run_in_real_time", lambda: False)
    monkeypatch.setattr(advice, "find_spec", lambda _: None)
    missing = real_device_advice(tmp_path)
    assert "pip install 'rehab-app[ros2]'" in missing[0]
    assert "CAP_SYS_NICE" in missing[2]
