"""The one place that chooses implementations: opens a clinic folder and wires its services.

A new service: a property in ``rehab_app.services.wiring`` (or ``wiring_records``), which says what it is
built of, and a field of the same name in ``Clinic``. The server builds all of them before it answers, a
command only what it uses.
"""

from __future__ import annotations

import errno
import socket
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

from rehab_app import __version__
from rehab_app.config import Settings, load_settings, resolve_folder
from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.later import later
from rehab_app.services.lease import ServerLease
from rehab_app.services.wiring import Wiring


def open_clinic(
    folder: Path | None = None, serving: bool = False, settings: Settings | None = None
) -> Clinic:
    """Open (and where needed create) a clinic folder.

    Args:
        folder: The folder, None for the default (``REHAB_DATA`` or the user's data folder).
        serving: Take the exclusive lease of the one server, and build every service at once.
        settings: What a person set, None to read it from the file and the environment.

    Returns:
        A context manager that closes the clinic.

    Raises:
        Refused: The folder cannot be used, a setting is wrong, or another server holds it.
    """
    place = resolve_folder(folder).create()
    held = load_settings(place).settings if settings is None else settings
    lease = ServerLease(place.lease) if serving else None
    wiring = Wiring(place, serving, held)
    wiring.outbox.bring()
    wiring.erasures.finish()
    wiring.audit.start()
    if serving:
        wiring.build_all()
        wiring.stations.start()
        wiring.outbox.start()
    return _clinic(wiring, lease)


def _clinic(wiring: Wiring, lease: ServerLease | None) -> Clinic:
    """Each service stands under its name in the wiring, and is built when it is first used."""
    held: dict[str, Any] = {
        "folder": wiring.place.root,
        "catalogue": wiring.catalogue,
        "version": __version__,
        "settings": wiring.settings,
        "audit": wiring.audit,
        "lease": lease,
        "closing": wiring.closing,
    }
    services = [one.name for one in fields(Clinic) if one.name not in held]
    return Clinic(**held, **{name: later(partial(getattr, wiring, name)) for name in services})


def check_port(host: str, port: int) -> None:
    """Refuse a port that cannot be listened on, before anything is started for it.

    Raises:
        Refused: The port is in use, needs more rights, or the address is not of this machine.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except OSError as error:
        value = "in use" if error.errno == errno.EADDRINUSE else f"not usable ({error.strerror or error})"
        raise Refused(
            f"port {port} on {host}", value, "free", "end what uses it, or choose another with --port"
        ) from error
