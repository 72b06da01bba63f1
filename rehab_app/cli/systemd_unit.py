"""The systemd unit of this installation: what it may see, write and ask for, and nothing beside."""

from __future__ import annotations

import sys
from pathlib import Path

from rehab_app.errors import Refused

STATE = "rehab-app"
_ALLOWED = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")

_UNIT = """\
[Unit]
Description=Clinic for hand rehabilitation
After=network-online.target
Wants=network-online.target
StartLimitIntervalSec=300
StartLimitBurst=5

[Service]
Type=notify
NotifyAccess=main
ExecStart={python} -m rehab_app serve
Environment=REHAB_DATA={data}
Environment=REHAB_LOG_LEVEL=info
Environment=MPLCONFIGDIR=%C/{state} XDG_CACHE_HOME=%C/{state} NUMBA_CACHE_DIR=%C/{state}
EnvironmentFile=-/etc/rehab-app.env
Restart=on-failure
RestartSec=2
WatchdogSec=30
# The stop is pressed and the session sealed first: never cut that short.
TimeoutStopSec=60
KillMode=mixed

{who}
StateDirectory={state}
StateDirectoryMode=0700
CacheDirectory={state}
RuntimeDirectory={state}
UMask=0077

# The motion process asks for SCHED_FIFO and locked memory; the server asks for a better nice value.
LimitRTPRIO=20
LimitNICE=-10
LimitMEMLOCK=infinity
LimitNOFILE=65536
LimitCORE=0

NoNewPrivileges=yes
CapabilityBoundingSet=
AmbientCapabilities=
ProtectSystem=strict
ProtectHome={home}
{paths}PrivateTmp=yes
PrivateUsers=yes
ProtectProc=invisible
ProtectClock=yes
ProtectHostname=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
ProtectControlGroups=yes
# USB cameras are found by netlink.
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK
RestrictNamespaces=yes
RestrictSUIDSGID=yes
LockPersonality=yes
RemoveIPC=yes
# Real time is needed (no RestrictRealtime), and kernels are compiled at run time (no MemoryDenyWriteExecute).
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallErrorNumber=EPERM
# Cameras and hand robots on USB and serial lines; take out what this clinic does not have.
DevicePolicy=closed
DeviceAllow=char-video4linux rw
DeviceAllow=char-usb_device rw
DeviceAllow=char-ttyUSB rw
DeviceAllow=char-ttyACM rw
SupplementaryGroups=video dialout

[Install]
WantedBy=multi-user.target
"""


def unit_text(user: str = "", data: Path | None = None, python: Path | None = None) -> str:
    """The unit's text.

    Args:
        user: Account that runs it; by default one that systemd makes.
        data: Clinic folder, absolute; by default the state folder that systemd makes.
        python: Interpreter that has the application, absolute; by default this one.

    Raises:
        Refused: A name or path cannot stand in a unit file.
    """
    interpreter = Path(sys.executable) if python is None else python
    if not set(user) <= _ALLOWED:
        raise Refused("user", repr(user[:40]), "letters, digits, _ and -", "name an account of this machine")
    for path in (interpreter, *(() if data is None else (data,))):
        _check(path)
    homes = [path for path in (interpreter, data) if path is not None and _in_home(path)]
    return _UNIT.format(
        python=interpreter,
        data=f"%S/{STATE}" if data is None else data,
        state=STATE,
        who=f"User={user}\nGroup={user}" if user else "DynamicUser=yes",
        home="read-only" if homes else "yes",
        paths="" if data is None else f"ReadWritePaths={data}\n",
    )


def _check(path: Path) -> None:
    """A path goes into the unit as it is, so nothing in it may mean something there."""
    text = str(path)
    if not text.isprintable() or set(text) & set("\"'\\%$;") or " " in text:
        bound = "without spaces, quotes, %, $, ; and backslashes"
        raise Refused("path for the unit", repr(text), bound, "use another folder")


def _in_home(path: Path) -> bool:
    return path.parts[:2] in (("/", "home"), ("/", "root"))
