from __future__ import annotations

import os
import socket
import stat
from dataclasses import fields
from functools import cached_property

import pytest

from rehab_app.bootstrap import check_port, open_clinic
from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.wiring import Wiring


def test_opening_makes_a_private_folder_and_is_repeatable(tmp_path):
    for _ in range(2):
        with open_clinic(tmp_path / "clinic") as clinic:
            assert clinic.folder == tmp_path / "clinic"
            assert clinic.accounts.set_up_needed()
            assert clinic.takes.list() == clinic.sessions.list() == ()
    assert stat.S_IMODE((tmp_path / "clinic").stat().st_mode) == 0o700


def test_one_server_per_folder_and_other_commands_beside_it(tmp_path):
    with open_clinic(tmp_path, serving=True):
        with pytest.raises(Refused, match=f"served by process {os.getpid()}"):
            open_clinic(tmp_path, serving=True)
        with open_clinic(tmp_path) as beside:
            assert beside.patients.list() == ()
    with open_clinic(tmp_path, serving=True):
        pass


def test_a_port_in_use_is_refused_and_a_free_one_is_not():
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        port = holder.getsockname()[1]
        with pytest.raises(Refused, match=rf"port {port} .*in use.*--port"):
            check_port("127.0.0.1", port)
    check_port("127.0.0.1", port)


def test_an_address_of_another_machine_is_refused():
    with pytest.raises(Refused, match="not usable"):
        check_port("192.0.2.1", 8080)


def test_every_service_of_a_clinic_is_wired_under_its_name():
    given = {"folder", "catalogue", "version", "settings", "audit", "lease", "closing"}
    services = {one.name for one in fields(Clinic)} - given
    wired = {name for name in services if isinstance(getattr(Wiring, name, None), cached_property)}
    assert wired == services
