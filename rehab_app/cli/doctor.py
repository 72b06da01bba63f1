"""What ``doctor`` looks at, each as one finding with a remedy."""

from __future__ import annotations

import os
import platform
import shutil
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rehab_app.bootstrap import check_port
from rehab_app.config import KEYS, ClinicFolder, load_settings
from rehab_app.errors import Refused
from rehab_app.services.object_queue import ErrandQueue
from rehab_app.services.outbox_folder import OutboxFolder
from rehab_app.services.station_clock import TRIPS, ClockOffset, clock_warning, offset_of, offset_words
from robot_iface.build import real_device_advice
from sessions.catalogue import Catalogue
from sessions.store import partials

_SPACE_BYTES = 1_000_000_000
_LATENESS_TICKS = 300
_TICK_NS = 1_000_000
_LATE_NS = 5_000_000
_OTHERS = 0o077


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing looked at.

    Attributes:
        name: What was looked at.
        ok: Whether it is as it should be.
        found: What was found, in words.
        remedy: What to do, empty where nothing is needed.
        figures: Numbers behind it, SI units in their names.
    """

    name: str
    ok: bool
    found: str
    remedy: str = ""
    figures: dict[str, float] = field(default_factory=dict[str, float])


def examine(folder: ClinicFolder, port: int) -> tuple[Finding, ...]:
    """Look at everything; nothing is changed.

    Args:
        folder: The clinic folder, which need not exist.
        port: Port that ``serve`` would use.
    """
    return (
        _python(),
        _physics(),
        _scheduling(),
        _lateness(),
        _space(folder),
        _port(port),
        _settings(folder),
        *_unsealed(folder),
        *_object_store(folder),
        *_outbox(folder),
        *_stations(folder),
        *_real_hand(),
    )


def unsealed(folder: ClinicFolder) -> tuple[Path, ...]:
    """Session files of a clinic folder that were never sealed and that nobody is writing now."""
    return (*partials(folder.takes), *partials(folder.sessions))


def _python() -> Finding:
    good = (3, 11) <= sys.version_info[:2] <= (3, 13) and sys.platform == "linux"
    found = f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
    return Finding("python", good, found, "" if good else "use Python 3.11 to 3.13 on Linux")


def _physics() -> Finding:
    try:
        found = version("mujoco")
    except PackageNotFoundError:
        return Finding("simulation", False, "MuJoCo is not installed", "install rehab-app again")
    return Finding("simulation", True, f"MuJoCo {found}")


def _scheduling() -> Finding:
    """Whether real-time scheduling may be had, as the motion process asks for it; tried and given back."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except OSError:
        return Finding(
            "scheduling",
            False,
            "real-time scheduling (SCHED_FIFO) is not allowed; simulation does not need it",
            "for a real robot, give the user CAP_SYS_NICE or an rtprio limit",
        )
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return Finding("scheduling", True, "real-time scheduling (SCHED_FIFO) is allowed")


def _lateness() -> Finding:
    """How late a plain 1 kHz loop wakes up on this machine, now."""
    late: list[int] = []
    deadline = time.monotonic_ns()
    for _ in range(_LATENESS_TICKS):
        deadline += _TICK_NS
        time.sleep(max(0.0, (deadline - time.monotonic_ns()) / 1e9))
        late.append(time.monotonic_ns() - deadline)
        deadline += late[-1] // _TICK_NS * _TICK_NS  # missed ticks are skipped, as the control loop does
    late.sort()
    middle, worst = late[len(late) // 2], late[int(0.99 * len(late))]
    good = worst < _LATE_NS
    return Finding(
        "timing",
        good,
        f"a 1 kHz loop wakes {middle / 1e3:.0f} us late (median), {worst / 1e3:.0f} us (99th percentile)",
        "" if good else "close other programs; a real robot needs a quieter machine",
        {"late_p50_s": middle / 1e9, "late_p99_s": worst / 1e9},
    )


def _space(folder: ClinicFolder) -> Finding:
    place = next(path for path in (folder.root, *folder.root.parents) if path.exists())
    free = shutil.disk_usage(place).free
    good = free >= _SPACE_BYTES and os.access(place, os.W_OK)
    return Finding(
        "clinic folder",
        good,
        f"{folder.root}: {free / 1e9:.1f} GB free",
        "" if good else "free some space or name another folder with --data",
        {"free_bytes": float(free)},
    )


def _port(port: int) -> Finding:
    try:
        check_port("127.0.0.1", port)
    except Refused as refusal:
        return Finding("port", False, str(refusal), "use another with --port")
    return Finding("port", True, f"{port} is free")


def _settings(folder: ClinicFolder) -> Finding:
    """Whether the settings can be read, and whether only their owner may read a secret in them."""
    try:
        loaded = load_settings(folder)
    except Refused as refusal:
        return Finding(
            "settings", False, str(refusal), "rehab-app config shows what holds once it is corrected"
        )
    file, origins = loaded.file, loaded.origins
    if file is None:
        return Finding("settings", True, "no file; the defaults and the environment hold")
    kept = [key.dotted for key in KEYS if key.secret and origins[key.dotted].startswith(file.name)]
    if kept and file.stat().st_mode & _OTHERS:
        found = f"{file} holds {', '.join(kept)}, and others may read it"
        return Finding("settings", False, found, "let only its owner read it: chmod 600")
    return Finding("settings", True, f"{file} is in order")


def _object_store(folder: ClinicFolder) -> Iterator[Finding]:
    """What waits for the object store, and why; nothing where nothing waits."""
    queue = ErrandQueue(folder.root)
    waiting, trouble = len(queue.waiting()), queue.trouble()
    if waiting or trouble:
        found = f"{waiting} recordings or deletions wait. {trouble}".strip()
        remedy = "rehab-app store push tries again now" if trouble else ""
        yield Finding("object store", not trouble, found, remedy, {"waiting": float(waiting)})


def _stations(folder: ClinicFolder) -> Iterator[Finding]:
    """How this machine's clock stands to the data base's, and the other stations'; nothing is changed."""
    try:
        settings = load_settings(folder).settings
        catalogue = Catalogue.look(folder.root, settings.catalogue_url)
        if catalogue is None:
            return
        with catalogue:
            own, others = offset_of(catalogue.clock_trips(TRIPS)), catalogue.stations()
    except Refused as refusal:
        yield Finding("stations", False, str(refusal), "the clocks could not be compared")
        return
    name = settings.station_name
    figures = {"offset_s": own.offset_ns / 1e9, "uncertainty_s": own.uncertainty_ns / 1e9}
    warning = clock_warning(name, own)
    words = f"{name}: its clock is {offset_words(own)}; {len(others)} known on this catalogue"
    yield Finding("stations", not warning, words, warning, figures)
    for one in others:
        warning = clock_warning(one.name, ClockOffset(one.offset_ns, one.uncertainty_ns))
        if warning and one.name != name:
            yield Finding("stations", False, f"{one.name}: its clock is off", warning)


def _outbox(folder: ClinicFolder) -> Iterator[Finding]:
    """What waits for the catalogue of a server, and what was set aside; nothing where neither is."""
    outbox = OutboxFolder(folder.root)
    waiting = len(outbox.names())
    if waiting:
        found = f"{waiting} records wait until the data base of the clinic answers"
        yield Finding("outbox", True, found, figures={"waiting": float(waiting)})
    for one in outbox.aside():
        found = f"{one.name} was set aside: {one.why}"
        remedy = f"see to what it says, then delete it from {outbox.folder.name}/aside of the clinic folder"
        yield Finding("outbox", False, found, remedy)


def _real_hand() -> Iterator[Finding]:
    """What a real hand needs; nothing of it is wrong where only the simulation is used."""
    for sentence in real_device_advice():
        yield Finding("real hand", True, sentence)


def _unsealed(folder: ClinicFolder) -> Iterator[Finding]:
    for path in unsealed(folder):
        yield Finding(
            "recording", False, f"{path.name} was never sealed", f"restore it with: rehab-app recover {path}"
        )
