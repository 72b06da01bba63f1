"""Everything about one patient as one file that they may take with them."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path

import msgspec

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue

IDENTITY, ROWS = "identity.json", "record.json"
_IDENTIFYING = ("given_name", "family_name", "birth_date")
_README = """Everything that the clinic's hand rehabilitation app keeps about one patient.

identity.json   who it is; the only file with a name. The other files know the pseudonym.
record.json     every entry by table: prescriptions, limits, scores, notes, pain, consents. SI units;
                times are nanoseconds since 1970 in UTC.
sessions/       recorded therapy sessions, and takes/ recordings of the patient's own hand: MCAP files,
                which Foxglove and the mcap libraries open.
reports/        reports that were made of them.
"""


class PatientExports:
    """Exports patients.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where exports are noted.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue, audit: Audit) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit

    def export(self, actor: Account, patient_id: str, target: Path) -> tuple[str, ...]:
        """Write the file; it is whole or absent.

        Args:
            actor: Who exports (verb "export").
            patient_id: Pseudonym.
            target: New file ending in .zip.

        Returns:
            Names in the file.

        Raises:
            Refused: The actor may not, the patient is unknown, or the target exists or cannot be written.
        """
        require(actor, "export")
        _check(target)
        rows = self._catalogue.patient_rows(patient_id)
        working = target.with_name(f".{target.name}.part")
        try:
            with open(os.open(working, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
                with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
                    self._fill(archive, patient_id, rows)
                    names = tuple(archive.namelist())
                file.flush()
                os.fsync(file.fileno())
            os.replace(working, target)
        except OSError as error:
            value = f"not written ({error.strerror or error})"
            raise Refused(
                f"export {target}", value, "in a place with space", "choose another place"
            ) from error
        finally:
            working.unlink(missing_ok=True)
        self._audit.note(actor, "export patient", patient_id, f"{len(names)} files")
        return names

    def _fill(self, archive: zipfile.ZipFile, patient: str, rows: dict[str, list[dict[str, object]]]) -> None:
        archive.writestr("README.txt", _README)
        own = rows["patients"][0]
        identity = {name: own[name] for name in ("id", *_IDENTIFYING)}
        archive.writestr(IDENTITY, _pretty(identity))
        known = {name: value for name, value in own.items() if name not in _IDENTIFYING}
        archive.writestr(ROWS, _pretty({**rows, "patients": [known]}))
        found = self._catalogue.belongings(patient)
        for path, _ in (*found.sessions, *found.takes):
            self._add(archive, self._folder.root / path)

    def _add(self, archive: zipfile.ZipFile, path: Path) -> None:
        """A sealed file with its digest and reports; what is gone is left out."""
        own = (path, storage.digest_beside(path), *sorted(self._folder.reports.glob(f"*{path.stem}*")))
        for one in own:
            if one.is_file():
                archive.write(one, one.relative_to(self._folder.root).as_posix())


def _check(target: Path) -> None:
    if target.suffix != ".zip":
        raise Refused("--out", str(target), "a file ending in .zip", "give it that ending")
    if target.exists():
        raise Refused("--out", f"{target}, which is there already", "a new file", "choose another name")
    if not target.parent.is_dir():
        raise Refused("folder of --out", f"{target.parent}, which is not there", "a folder", "make it first")


def _pretty(content: object) -> bytes:
    return msgspec.json.format(msgspec.json.encode(content), indent=2)
