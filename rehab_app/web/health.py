"""The page /healthz: may this server be given work? Four looks, without identity, at most once a second."""

from __future__ import annotations

import asyncio
import shutil
import time
from dataclasses import asdict, dataclass

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from rehab_app.config import ClinicFolder, HealthSettings
from rehab_app.services.clinic import Clinic
from rehab_app.services.sign_ins import IDLE_KEY
from sessions.filelock import is_locked

_KEPT_S = 1.0
_PATIENCE_S = 2.0
_LOOK_S = 0.05


@dataclass(frozen=True, slots=True)
class Health:
    """What was found.

    Attributes:
        catalogue: The data base answers.
        disk: Enough space is left.
        motion: While a movement is played, its picture goes on.
        lease: This server still holds the clinic folder.
    """

    catalogue: bool
    disk: bool
    motion: bool
    lease: bool

    @property
    def ready(self) -> bool:
        """Whether all is well."""
        return self.catalogue and self.disk and self.motion and self.lease


class Doctor:
    """Looks at most once a second however often it is asked, one look at a time.

    Args:
        clinic: The clinic.
    """

    def __init__(self, clinic: Clinic) -> None:
        self._clinic = clinic
        self._wanted: HealthSettings = clinic.settings.health
        self._looking = asyncio.Lock()
        self._asking: asyncio.Task[None] | None = None
        self._found: Health | None = None
        self._found_s = 0.0

    async def look(self) -> Health:
        """What holds now, or did within the last second."""
        async with self._looking:
            if self._found is None or time.monotonic() - self._found_s >= _KEPT_S:
                self._found = Health(
                    catalogue=await self._catalogue_answers(),
                    disk=self._has_space(),
                    motion=await self._motion_lives(),
                    lease=self._holds_lease(),
                )
                self._found_s = time.monotonic()
            return self._found

    async def _catalogue_answers(self) -> bool:
        """A data base that hangs costs one thread, however often somebody asks."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(run_in_threadpool(self._ask))
            self._asking.add_done_callback(asyncio.Task.exception)  # whatever it is, it has been heard
        done, _ = await asyncio.wait((self._asking,), timeout=_PATIENCE_S)
        return bool(done) and self._asking.exception() is None

    def _ask(self) -> None:
        self._clinic.catalogue.setting(IDLE_KEY)

    def _has_space(self) -> bool:
        try:
            return shutil.disk_usage(self._clinic.folder).free >= self._wanted.free_disk_bytes
        except OSError:
            return False

    async def _motion_lives(self) -> bool:
        """While a movement is played, a new picture comes within the time that a person set."""
        first, end_s = self._clinic.live.snapshot(), time.monotonic() + self._wanted.heartbeat_s
        while first.state == "playing" and time.monotonic() < end_s:
            await asyncio.sleep(_LOOK_S)
            now = self._clinic.live.snapshot()
            if now.state != "playing" or now.frame != first.frame:
                return True
        return first.state != "playing"

    def _holds_lease(self) -> bool:
        """Tried rather than remembered: the file may have been taken away under the server."""
        if self._clinic.lease is None:
            return False
        try:
            return is_locked(ClinicFolder(self._clinic.folder).lease)
        except OSError:
            return False


async def ready(request: Request) -> Response:
    """Whether this server may be given work: 200, else 503."""
    doctor: Doctor = request.app.state.doctor
    found = await doctor.look()
    content = {"live": True, "ready": found.ready, "checks": asdict(found)}
    return JSONResponse(content, 200 if found.ready else 503)


async def live(request: Request) -> Response:
    """Whether the server answers at all; it looks at nothing."""
    del request
    return JSONResponse({"live": True})
