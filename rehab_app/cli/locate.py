"""A session or take named on the command line: a path, else an id of the catalogue."""

from __future__ import annotations

from pathlib import Path

from rehab_app.services.storage import is_path


def locate(named: str, data: Path | None) -> Path:
    """The file that is meant; the clinic folder is opened only for what is no file.

    Raises:
        Refused: There is neither such a file nor such an id.
    """
    if is_path(named):
        return Path(named)
    from rehab_app.bootstrap import open_clinic

    with open_clinic(data) as clinic:
        return clinic.sessions.path(named)
