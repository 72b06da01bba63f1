"""A device file says what a real hand is; one that cannot be is refused in one sentence."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robot_iface.adapters import device_file
from robot_iface.adapters.device_file import device_names, read_device
from robot_iface.adapters.ros2 import ros2_capabilities
from robot_iface.errors import Refused
from robot_iface.safety.yielding import BRAKE_NMS_RAD
from robot_iface.sim import DRIVEN

Write = Callable[..., Any]


def test_the_capabilities_are_those_of_the_file(write_device: Write, tmp_path: Path) -> None:
    device = write_device(quick_release="true", unpowered="damped")
    found = ros2_capabilities(f"ros2:{device.name}", tmp_path)
    assert found.name == f"ros2:{device.name}"
    assert found.joint_names == DRIVEN
    assert found.period_ns == 10_000_000
    assert (found.simulated, found.worn, found.unpowered, found.quick_release) == (
        False,
        True,
        "damped",
        True,
    )
    assert np.rad2deg(found.q_max_rad) == pytest.approx(120.0)
    assert found.tau_max_nm == pytest.approx(0.6)
    assert found.position_sensors == 1
    assert found.inertia_kg_m2 == 0.0025


def test_devices_are_found_by_their_files(
    write_device: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = write_device()
    monkeypatch.setenv(device_file.FOLDER_VARIABLE, str(tmp_path))
    assert device_names() == (f"ros2:{device.name}",)
    assert ros2_capabilities(f"ros2:{device.name}").name == f"ros2:{device.name}"


@pytest.mark.parametrize("name", ["ros2:other", "ros2:../secret", "ros2:", "ros2:A", "ros2:" + "x" * 1000])
def test_an_unknown_name_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(Refused, match="device file"):
        ros2_capabilities(name, tmp_path)


def test_the_brake_that_a_device_must_bear_is_the_supervisors() -> None:
    assert device_file.HARDEST_DAMPING_NMS_RAD == BRAKE_NMS_RAD


@pytest.mark.parametrize(
    ("found", "written", "sentence"),
    [
        ('name = "stand-in', 'name = "other', "the name of its file"),
        ('"effort"', '"velocity"', "Invalid enum value"),
        ("period_ms = 10.0", "period_ms = 200.0", "0.5 to 50 ms"),
        ("period_ms = 10.0", "period_ms = nan", "0.5 to 50 ms"),
        ("period_ms = 10.0", "period_ms = 40.0", "the brake would shake"),
        ("inertia_kg_m2 = 0.0025", "", "the brake would shake"),
        ('name = "index_pip"', 'name = "index_pap"', "'index_pap'"),
        ('name = "index_pip"', 'name = "index_mcp_flexion"', "twice"),
        ('ros = "motor_3"', 'ros = "motor_2"', "twice"),
        ('ros = "motor_3"', 'ros = ""', "driver's name"),
        ("sign = -1", "sign = 2", "sign"),
        ("min_deg = -60.0", "min_deg = 125.0", "125 to 120 deg"),
        ("max_deg = 120.0", "max_deg = inf", "within"),
        ("offset_deg = 10.0", "offset_deg = nan", "offset"),
        ("tau_max_nm = 0.6", "tau_max_nm = 0", "above 0"),
        ("tau_max_nm = 0.6", "tau_max = 0.6", "tau_max"),
        ('interface = "lo"', "interface = '\"/><x'", "network interface"),
        ('interface = "lo"', 'peers = ["a b"]', "an address"),
        ('command = "effort_controller/commands"', 'command = "/effort"', "ROS 2 name"),
        ("domain = ", "domain = 9", "0 to 232"),
        ("[topics]", "[topics", "unreadable"),
    ],
)
def test_what_cannot_be_is_refused(
    found: str, written: str, sentence: str, write_device: Write, tmp_path: Path
) -> None:
    path = tmp_path / f"{write_device().name}.toml"
    text = path.read_text()
    assert found in text
    path.write_text(text.replace(found, written, 1))
    with pytest.raises(Refused, match=r"must be") as refused:
        read_device(path.stem, tmp_path)
    assert sentence in str(refused.value)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "odd.toml").write_bytes(bytes(range(256)))
    with pytest.raises(Refused, match="unreadable"):
        read_device("odd", tmp_path)


def test_the_example_of_the_documentation_is_a_device(tmp_path: Path) -> None:
    text = (Path(__file__).parents[3] / "docs" / "real-devices.md").read_text()
    example = text.split("```toml\n")[1].split("```")[0]
    (tmp_path / "clinic-hand.toml").write_text(example)
    found = ros2_capabilities("ros2:clinic-hand", tmp_path)
    assert found.joint_names == ("index_mcp_flexion",)
    assert found.position_sensors == 2


def test_a_worn_hand_moved_by_position_needs_a_known_spring(write_device: Write) -> None:
    with pytest.raises(Refused, match="no torque on a hand could be bounded"):
        write_device("trajectory", drive="servo_nm_rad = 0.0")
    shown = write_device("trajectory", drive="servo_nm_rad = 0.0", worn="false")
    assert shown.capabilities.worn is False


_WITHOUT_EXTRA = """
import sys
from pathlib import Path
sys.modules["cyclonedds"] = None
from robot_iface.adapters.ros2 import open_ros2, ros2_capabilities
from robot_iface.errors import Refused
ros2_capabilities(sys.argv[1], Path(sys.argv[2]))
try:
    open_ros2(sys.argv[1], Path(sys.argv[2]))
except Refused as refused:
    sys.stdout.write(str(refused))
"""


def test_without_the_extra_the_refusal_names_it(write_device: Write, tmp_path: Path) -> None:
    argument = [sys.executable, "-c", _WITHOUT_EXTRA, write_device().name, str(tmp_path)]
    said = subprocess.run(argument, check=True, capture_output=True, text=True)
    assert said.stdout.startswith("cyclonedds is not installed")
    assert "pip install 'rehab-app[ros2]'" in said.stdout
