"""A real PostgreSQL server on a loopback port, started once per process when the first test asks for it."""

from __future__ import annotations

import atexit
import itertools
import os
import pwd
import secrets
import shutil
import socket
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

import psycopg
import pytest
from psycopg import sql

_SETTINGS = ("fsync=off", "full_page_writes=off", "max_connections=60")
_NUMBERS = itertools.count(1)


class PostgresServer:
    """A server with a superuser ``clinic`` and a password of its own.

    Args:
        binaries: Folder of ``initdb`` and ``pg_ctl``.
    """

    def __init__(self, binaries: Path) -> None:
        self._binaries = binaries
        self._folder = Path(tempfile.mkdtemp(prefix="postgres-"))
        self.password = secrets.token_hex(8)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = int(probe.getsockname()[1])
        (self._folder / "password").write_text(self.password)
        if os.geteuid() == 0:
            for path in (self._folder, self._folder / "password"):
                shutil.chown(path, *_user())
        self._run(
            "initdb",
            "-U",
            "clinic",
            "-A",
            "scram-sha-256",
            "--pwfile",
            self._folder / "password",
            "-E",
            "UTF8",
        )
        self.start()

    def url(self, data_base: str = "postgres", password: str | None = None) -> str:
        """SQLAlchemy's address of a data base of this server."""
        return f"postgresql://clinic:{password or self.password}@127.0.0.1:{self.port}/{data_base}"

    def fresh(self) -> str:
        """The address of a new, empty data base."""
        name = f"clinic_{next(_NUMBERS)}"
        with psycopg.connect(self.url(), autocommit=True) as connection:
            connection.execute(sql.SQL("CREATE DATABASE {}").format(sql.Identifier(name)))
        return self.url(name)

    def start(self) -> None:
        """Start it, and wait until it answers."""
        options = " ".join(
            f"-c {one}" for one in (*_SETTINGS, f"port={self.port}", "listen_addresses=127.0.0.1")
        )
        self._run("pg_ctl", "-w", "-l", self._folder / "log", "-o", f"{options} -k {self._folder}", "start")

    def stop(self) -> None:
        """Take it away from whoever is connected."""
        self._run("pg_ctl", "-w", "-m", "immediate", "stop")

    def processes(self) -> tuple[int, ...]:
        """Every process of the server, its connections' among them."""
        first = int((self._folder / "data" / "postmaster.pid").read_text().split()[0])
        children = Path(f"/proc/{first}/task/{first}/children").read_text().split()
        return (*(int(child) for child in children), first)

    def remove(self) -> None:
        """Stop it and forget what it held."""
        try:
            self.stop()
        except subprocess.CalledProcessError:
            pass  # a test had stopped it
        shutil.rmtree(self._folder, ignore_errors=True)

    def _run(self, program: str, *arguments: str | Path) -> None:
        become = (
            ["setpriv", "--reuid", _user()[0], "--regid", _user()[1], "--clear-groups"]
            if os.geteuid() == 0
            else []
        )
        where = ["-D", str(self._folder / "data")]
        subprocess.run(
            [*become, str(self._binaries / program), *where, *(str(one) for one in arguments)],
            check=True,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


@lru_cache(maxsize=1)
def server() -> PostgresServer:
    """The server of this process; skips the test where PostgreSQL is absent, and fails it in CI."""
    found = _binaries()
    if found is None:
        missing = "the tests of PostgreSQL need its server (Debian: apt-get install postgresql)"
        if os.environ.get("CI") == "true":
            pytest.fail(missing)
        pytest.skip(missing)
    made = PostgresServer(found)
    atexit.register(made.remove)
    return made


def _binaries() -> Path | None:
    homes = sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    on_path = shutil.which("initdb")
    candidates = [*homes, *([Path(on_path).parent] if on_path else [])]
    return next(
        (home for home in candidates if (home / "initdb").exists() and (home / "pg_ctl").exists()), None
    )


def _user() -> tuple[str, str]:
    """Who runs the server where the tests run as root, which PostgreSQL refuses."""
    names = {entry.pw_name for entry in pwd.getpwall()}
    return ("postgres", "postgres") if "postgres" in names else ("nobody", "nogroup")
