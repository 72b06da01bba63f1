"""What a real hand needs before anybody puts a finger into it, and what of it this computer has."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from robot_iface.adapters.device_file import FOLDER_VARIABLE, device_names, devices_folder
from robot_iface.loop import may_run_in_real_time

_PEOPLE = (
    "A stop that cuts motor power without any software, in reach of the patient and of the therapist.",
    "Mechanical stops at the ends of the hand's range: no motor of this size holds a strong spasm.",
    "A driver with a watchdog of its own (50 ms): a motion process that is killed brakes nothing.",
    'Its behaviour without power stated in its device file ("free", "damped" or "locked"); a worn hand that '
    "locks needs a quick release.",
    "Confirmation by name for every run: the simulation is always the default.",
)


def real_device_advice(folder: Path | None = None) -> tuple[str, ...]:
    """What a real hand needs, a sentence each, those first that this computer can answer by itself.

    Args:
        folder: Where device files lie; by default $REHAB_DEVICES or the user's configuration folder.
    """
    return (_middleware(), _devices(folder), _priority(), *_PEOPLE)


def _middleware() -> str:
    installed = "installed" if find_spec("cyclonedds") else "missing: pip install 'rehab-app[ros2]'"
    return f"The ros2 extra (Cyclone DDS; no ROS installation): {installed}."


def _devices(folder: Path | None) -> str:
    found = ", ".join(device_names(folder)) or "none so far"
    place = f"{devices_folder(folder)} (or ${FOLDER_VARIABLE})"
    return f"A device file in {place}, see docs/real-devices.md: {found}."


def _priority() -> str:
    if may_run_in_real_time():
        return "Real-time priority (SCHED_FIFO) for the motion process: permitted."
    remedy = "give it CAP_SYS_NICE or an rtprio limit of 50 (/etc/security/limits.conf)"
    return (
        f"Real-time priority (SCHED_FIFO) for the motion process: refused; {remedy}, or ticks will be late."
    )
