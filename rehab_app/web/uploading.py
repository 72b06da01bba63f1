"""Keeps the object store up with what is sealed while the server runs, and tells the log."""

from __future__ import annotations

import random

from rehab_app.services.clinic import Clinic
from rehab_app.services.object_worker import UploadWorker
from rehab_app.web.server_log import tell


def keep_up(clinic: Clinic) -> UploadWorker:
    """Begin sending, where there is an object store; it ends as the clinic closes.

    Args:
        clinic: The open clinic.
    """

    def told(good: bool, sentence: str) -> None:
        if not good:
            tell("object store", said=sentence, waiting=clinic.uploads.waiting())

    worker = UploadWorker(clinic.uploads, random.Random(), told)  # chance by the system: stations must differ
    clinic.closing.callback(worker.close)
    worker.start()
    return worker
