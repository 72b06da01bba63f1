"""A stand-in device in a process of its own, its device file, and a plan for it."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from robot_iface.adapters.device_file import Device, read_device
from robot_iface.sim import DRIVEN

DOMAIN = 20 + os.getpid() % 200  # test runs beside each other do not meet
HERE = Path(__file__).parent

HEAD = """
name = "{name}"
period_ms = {period_ms}
command = "{command}"
worn = {worn}
unpowered = "{unpowered}"
quick_release = {quick_release}

[topics]
command = "{topic}"

[network]
domain = {domain}
interface = "lo"
"""
JOINT = """
[[joint]]
name = "{name}"
ros = "{ros}"
sign = {sign}
offset_deg = {offset}
min_deg = {low}
max_deg = {high}
tau_max_nm = 0.6
{drive}
"""


def device_text(
    name: str, command: str = "effort", joints: tuple[str, ...] = DRIVEN, drive: str = "", **change: Any
) -> str:
    """A device file; every second joint turns the other way round and has its zero elsewhere."""
    fields = {"period_ms": 10.0, "worn": "true", "unpowered": "free", "quick_release": "false"} | change
    topic = "effort_controller/commands" if command == "effort" else "joint_trajectory"
    text = HEAD.format(name=name, command=command, topic=topic, domain=DOMAIN, **fields)
    drive = drive or ("inertia_kg_m2 = 0.0025" if command == "effort" else "servo_nm_rad = 4.0")
    for index, joint in enumerate(joints):
        odd = index % 2
        text += JOINT.format(
            name=joint,
            ros=f"motor_{index}",
            sign=-1 if odd else 1,
            offset=10.0 if odd else 0.0,
            low=-60.0,
            high=120.0,
            drive=drive,
        )
    return text


class Process:
    """A process that speaks JSON lines, seen from the test.

    Args:
        script: Its file, beside this one.
        argument: What it is told.
    """

    def __init__(self, script: str, argument: dict[str, Any]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / script), json.dumps(argument)],
            stdout=subprocess.PIPE,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
        self.lines: list[dict[str, Any]] = []
        self._rest = b""

    def wait_for(self, key: str, value: Any = None, within_s: float = 60.0) -> dict[str, Any]:
        """The next line that has this key (with this value, where one is given)."""
        assert self.process.stdout is not None
        stream = self.process.stdout.fileno()
        while True:
            while b"\n" in self._rest:
                text, self._rest = self._rest.split(b"\n", 1)
                line = json.loads(text)
                self.lines.append(line)
                if key in line and value in (None, line[key]):
                    return line
            ready, _, _ = select.select([stream], [], [], within_s)
            content = os.read(stream, 65536) if ready else b""
            assert content, f"no {key} {value}, but {self.lines}"
            self._rest += content

    def ended(self) -> list[dict[str, Any]]:
        """Every line that it has ever said; it ends."""
        self.kill()
        assert self.process.stdout is not None
        said = (self._rest + self.process.stdout.read()).splitlines()
        return self.lines + [json.loads(line) for line in said]

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def close(self) -> None:
        self.kill()
        if self.process.stdout is not None:
            self.process.stdout.close()


@pytest.fixture
def processes() -> Iterator[Callable[..., Process]]:
    """Starts processes; all of them are ended with the test."""
    started: list[Process] = []

    def start(script: str, **argument: Any) -> Process:
        started.append(Process(script, argument))
        return started[-1]

    yield start
    for process in started:
        process.close()


@pytest.fixture
def write_device(tmp_path: Path) -> Callable[..., Device]:
    """Writes a device file into the test's folder and reads it back."""

    def write(command: str = "effort", **change: Any) -> Device:
        name = f"stand-in-{os.getpid()}"
        (tmp_path / f"{name}.toml").write_text(device_text(name, command, **change))
        return read_device(name, tmp_path)

    return write


@pytest.fixture
def stand_in(
    write_device: Callable[..., Device], processes: Callable[..., Process], tmp_path: Path
) -> Callable[..., tuple[Device, Process]]:
    """Writes a device file and starts a stand-in for it."""

    def start(
        command: str = "effort", file: dict[str, Any] | None = None, **options: Any
    ) -> tuple[Device, Process]:
        device = write_device(command, **(file or {}))
        process = processes("stand_in.py", folder=str(tmp_path), device=device.name, **options)
        process.wait_for("event", "ready")
        return device, process

    return start
