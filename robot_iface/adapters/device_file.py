"""Device files: what a real hand is, written once by whoever installs it, as TOML (docs/real-devices.md)."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import JOINTS, THESIS_INERTIA_KG_M2, Capabilities

FOLDER_VARIABLE = "REHAB_DEVICES"
PREFIX = "ros2:"
HARDEST_DAMPING_NMS_RAD = 0.15
"""The damping with which the supervisor brakes; a device must be able to render it."""
_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,62}")
_INTERFACE = re.compile(r"[A-Za-z0-9._-]{0,15}")
_PEER = re.compile(r"[A-Za-z0-9.:-]{1,64}")
_TOPIC = re.compile(r"[A-Za-z][A-Za-z0-9_/]{0,120}")
_STABLE_SHARE = 0.7


class Joint(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One joint: whose it is, what the driver calls it, and what it can do. Degrees, as a person wrote it.

    ``second`` and ``torque`` name further rows of the joint state: a redundant position sensor, and a sensor
    of the torque between device and hand (its effort). ``servo_nm_rad`` is the stiffness of the driver's own
    position control, ``inertia_kg_m2`` the least inertia that its motor moves; the
    thesis's where it is not stated, which only a trajectory driver may leave out.
    """

    name: str
    ros: str
    min_deg: float
    max_deg: float
    tau_max_nm: float
    sign: Literal[-1, 1] = 1
    offset_deg: float = 0.0
    inertia_kg_m2: float = 0.0
    servo_nm_rad: float = 0.0
    second: str = ""
    torque: str = ""


class Topics(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Names of the ROS 2 topics, without the leading slash."""

    state: str = "joint_states"
    command: str = "joint_trajectory"
    power: str = "hand/enable"
    faults: str = "hand/faults"
    clear: str = "hand/clear_faults"


class Network(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the device is reached: DDS domain, network interface (empty: any), unicast peers."""

    domain: int = 0
    interface: str = ""
    peers: tuple[str, ...] = ()


class Device(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A device file. ``command`` is what the driver takes: joint efforts, or points of a trajectory."""

    name: str
    period_ms: float
    command: Literal["effort", "trajectory"]
    unpowered: Literal["free", "damped", "locked"]
    joint: tuple[Joint, ...]
    worn: bool = True
    quick_release: bool = False
    chain: Literal["hand", "dlr-hit-ii"] = "hand"
    encoder_std_deg: float = 0.05
    topics: Topics = Topics()
    network: Network = Network()

    @property
    def period_ns(self) -> int:
        """Period of the driver's state and of the control loop."""
        return round(self.period_ms * 1e6)

    @property
    def capabilities(self) -> Capabilities:
        """What the device is and can do."""
        rows = self.joint
        return Capabilities(
            name=PREFIX + self.name,
            simulated=False,
            joint_names=tuple(row.name for row in rows),
            period_ns=self.period_ns,
            q_min_rad=np.deg2rad([row.min_deg for row in rows]),
            q_max_rad=np.deg2rad([row.max_deg for row in rows]),
            tau_max_nm=np.array([row.tau_max_nm for row in rows]),
            worn=self.worn,
            unpowered=self.unpowered,
            encoder_std_rad=float(np.deg2rad(self.encoder_std_deg)),
            quick_release=self.quick_release,
            chain=self.chain,
            position_sensors=2 if all(row.second for row in rows) else 1,
            inertia_kg_m2=min(row.inertia_kg_m2 or THESIS_INERTIA_KG_M2 for row in rows),
        )


def devices_folder(folder: Path | None = None) -> Path:
    """Where device files lie: the argument, else $REHAB_DEVICES, else the user's configuration folder."""
    if folder is not None:
        return folder
    given = os.environ.get(FOLDER_VARIABLE)
    configured = os.environ.get("XDG_CONFIG_HOME") or str(Path.home() / ".config")
    return Path(given) if given else Path(configured) / "rehab-app" / "devices"


def device_names(folder: Path | None = None) -> tuple[str, ...]:
    """Names of the devices that have a file, with their prefix, in order."""
    files = devices_folder(folder).glob("*.toml")
    return tuple(sorted(PREFIX + path.stem for path in files if _NAME.fullmatch(path.stem)))


def read_device(device: str, folder: Path | None = None) -> Device:
    """Read and check a device file.

    Args:
        device: Name of the device, with or without ``ros2:``.
        folder: Where the files lie; by default ``devices_folder()``.

    Raises:
        Refused: There is no such file, or it says something that cannot be.
    """
    name = device.removeprefix(PREFIX)
    path = devices_folder(folder) / f"{name}.toml"
    if not _NAME.fullmatch(name) or not path.is_file():
        known = ", ".join(device_names(folder)) or "none so far"
        bound = f"described in {path.parent} ({known})"
        raise Refused("robot", repr(device[:80]), bound, "write its device file as docs/real-devices.md says")
    try:
        read = msgspec.toml.decode(path.read_bytes(), type=Device)
    except (msgspec.DecodeError, UnicodeDecodeError, OSError) as error:
        raise Refused(
            f"device file {name}.toml", f"unreadable ({error})", "as docs/real-devices.md says", "correct it"
        ) from error
    _check(read, name)
    return read


def _check(device: Device, name: str) -> None:
    """Refuse the first thing that cannot be."""
    refuse = _refuser(name)
    period_s = device.period_ms * 1e-3
    refuse("name", device.name, device.name == name, f"{name}, the name of its file")
    refuse("period", f"{device.period_ms:g} ms", 0.5 <= device.period_ms <= 50.0, "0.5 to 50 ms")
    refuse("encoder", f"{device.encoder_std_deg:g} deg", 0.0 <= device.encoder_std_deg <= 5.0, "0 to 5 deg")
    _check_network(device, refuse)
    refuse("joint list", "empty", bool(device.joint), "one [[joint]] per driven joint")
    for joint in device.joint:
        _check_joint(joint, refuse)
        _check_drive(device, joint, period_s, refuse)
    for kind in ("name", "ros"):
        names = [getattr(joint, kind) for joint in device.joint]
        twice = [entry for entry in names if names.count(entry) > 1]
        refuse(f"joint {kind}", f"{twice[:1]} twice", not twice, "each once")


def _check_network(device: Device, refuse: Callable[[str, str, bool, str], None]) -> None:
    network, topics = device.network, device.topics
    refuse("domain", str(network.domain), 0 <= network.domain <= 232, "0 to 232")
    interface = network.interface
    refuse("interface", repr(interface), _INTERFACE.fullmatch(interface) is not None, "a network interface")
    for peer in network.peers:
        refuse("peer", repr(peer), _PEER.fullmatch(peer) is not None, "an address")
    for topic in (topics.state, topics.command, topics.power, topics.faults, topics.clear):
        refuse("topic", repr(topic), _TOPIC.fullmatch(topic) is not None, "a ROS 2 name without leading /")


def _check_joint(joint: Joint, refuse: Callable[[str, str, bool, str], None]) -> None:
    refuse("joint", repr(joint.name), joint.name in JOINTS, "one of " + ", ".join(JOINTS))
    refuse(f"ROS name of {joint.name}", "empty", bool(joint.ros), "the driver's name of the joint")
    low, high = joint.min_deg, joint.max_deg
    opens = -180.0 <= low < high <= 180.0
    refuse(f"range of {joint.name}", f"{low:g} to {high:g} deg", opens, "a range within +-180 deg")
    offset = joint.offset_deg
    refuse(f"offset of {joint.name}", f"{offset:g} deg", abs(offset) <= 360.0, "within +-360 deg")
    cap = joint.tau_max_nm
    refuse(f"torque of {joint.name}", f"{cap:g} Nm", 0.0 < cap <= 20.0, "above 0, at most 20 Nm")


def _check_drive(
    device: Device, joint: Joint, period_s: float, refuse: Callable[[str, str, bool, str], None]
) -> None:
    """What the kind of command needs: efforts a stable brake, points a known spring."""
    if device.command == "effort":
        bearable = _STABLE_SHARE * joint.inertia_kg_m2 / period_s
        value = f"{bearable:.3g} Nms/rad with {joint.inertia_kg_m2:g} kg m^2 at {device.period_ms:g} ms"
        bound = f"at least {HARDEST_DAMPING_NMS_RAD:g}, or the brake would shake (0.7 inertia / period)"
        refuse(f"damping of {joint.name}", value, bearable >= HARDEST_DAMPING_NMS_RAD, bound)
    elif device.worn:
        stiffness = joint.servo_nm_rad
        bound = "the stiffness of the driver's position control, or no torque on a hand could be bounded"
        refuse(f"servo_nm_rad of {joint.name}", f"{stiffness:g}", 0.0 < stiffness <= 1000.0, bound)


def _refuser(name: str) -> Callable[[str, str, bool, str], None]:
    def refuse(what: str, value: str, allowed: bool, bound: str) -> None:
        if not allowed:
            raise Refused(f"device file {name}.toml, {what}", value, bound, "correct the device file")

    return refuse
