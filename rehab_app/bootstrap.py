"""The one place that chooses implementations: opens a clinic folder and wires its services."""

from __future__ import annotations

import errno
import socket
from pathlib import Path

from rehab_app import __version__
from rehab_app.config import resolve_folder
from rehab_app.errors import Refused
from rehab_app.services.accounts import Accounts
from rehab_app.services.assessment import Assessment
from rehab_app.services.audit import Audit
from rehab_app.services.calibrations import Calibrations, Hands
from rehab_app.services.clinic import Clinic
from rehab_app.services.clinical import Clinical
from rehab_app.services.lease import ServerLease
from rehab_app.services.limit_acts import LimitActs
from rehab_app.services.live import LiveDesk
from rehab_app.services.marker_names import MarkerNames
from rehab_app.services.patient_limits import PatientLimits
from rehab_app.services.patients import Patients
from rehab_app.services.planning import Planner
from rehab_app.services.reports import Reports
from rehab_app.services.retouching import Retouching
from rehab_app.services.runs import Runs
from rehab_app.services.sessions import Sessions
from rehab_app.services.takes import Takes
from rehab_app.services.therapy import Therapy
from rehab_app.services.wearer import Wearers
from sessions.catalogue import Catalogue


def open_clinic(folder: Path | None = None, serving: bool = False) -> Clinic:
    """Open (and where needed create) a clinic folder.

    Args:
        folder: The folder, None for the default (``REHAB_DATA`` or the user's data folder).
        serving: Take the exclusive lease of the one server.

    Returns:
        A context manager that closes the clinic.

    Raises:
        Refused: The folder cannot be used, or another server holds it.
    """
    place = resolve_folder(folder).create()
    lease = ServerLease(place.lease) if serving else None
    catalogue = Catalogue.open(place.root)
    audit = Audit(catalogue)
    calibrations, hands = Calibrations(catalogue, audit), Hands(catalogue, audit)
    takes = Takes(place, catalogue, audit, calibrations, hands)
    clinical, limits = Clinical(catalogue, audit), PatientLimits(catalogue, audit)
    wearers, runs = Wearers(clinical, limits), Runs(place, catalogue, audit)
    therapy = Therapy(catalogue, takes, clinical, Planner(catalogue, wearers), runs, audit)
    assessment = Assessment(catalogue, clinical, wearers, limits, therapy, runs)
    sessions = Sessions(place, catalogue)
    audit.start()
    return Clinic(
        folder=place.root,
        catalogue=catalogue,
        version=__version__,
        audit=audit,
        accounts=Accounts(catalogue, audit),
        patients=Patients(catalogue, audit),
        clinical=clinical,
        limits=LimitActs(catalogue, clinical, limits),
        calibrations=calibrations,
        hands=hands,
        takes=takes,
        marker_names=MarkerNames(place, takes, calibrations),
        retouching=Retouching(place, takes),
        therapy=therapy,
        assessment=assessment,
        sessions=sessions,
        reports=Reports(place, sessions, audit),
        live=LiveDesk(takes, therapy, assessment, audit),
        lease=lease,
    )


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
