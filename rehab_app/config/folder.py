"""Where a clinic's files lie: one private folder, from the option, the environment or the user's own."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from rehab_app.errors import Refused

ENVIRONMENT = "REHAB_DATA"
_PRIVATE = 0o700


@dataclass(frozen=True, slots=True)
class ClinicFolder:
    """The layout of a clinic folder.

    Attributes:
        root: The folder itself, readable by its owner only.
    """

    root: Path

    @property
    def takes(self) -> Path:
        """Recorded demonstrations."""
        return self.root / "takes"

    @property
    def sessions(self) -> Path:
        """Therapy sessions."""
        return self.root / "sessions"

    @property
    def reports(self) -> Path:
        """Rendered reports."""
        return self.root / "reports"

    @property
    def secret(self) -> Path:
        """Key that signs sign-in cookies, made by the web shell, mode 0600."""
        return self.root / "secret"

    @property
    def lease(self) -> Path:
        """Lock of the one server."""
        return self.root / "server.lock"

    def create(self) -> ClinicFolder:
        """Make the folder and its rooms, private to the owner, where they do not exist yet.

        Raises:
            Refused: Something that is no folder is in the way, or the place is not writable.
        """
        try:
            for folder in (self.root, self.takes, self.sessions, self.reports):
                folder.mkdir(mode=_PRIVATE, parents=True, exist_ok=True)
        except OSError as error:
            raise Refused(
                "clinic folder",
                f"{self.root} ({error.strerror})",
                "a folder that can be written",
                "name another with --data or REHAB_DATA",
            ) from error
        return self


def resolve_folder(data: Path | None = None) -> ClinicFolder:
    """The clinic folder: ``data``, else ``REHAB_DATA``, else the user's data folder (XDG).

    Args:
        data: Folder given on the command line.
    """
    if data is not None:
        return ClinicFolder(data.expanduser().absolute())
    named = os.environ.get(ENVIRONMENT, "")
    if named:
        return ClinicFolder(Path(named).expanduser().absolute())
    share = os.environ.get("XDG_DATA_HOME", "")
    home = Path(share) if share else Path.home() / ".local" / "share"
    return ClinicFolder((home / "rehab-app").absolute())
