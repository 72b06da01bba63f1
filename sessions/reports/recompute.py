"""Makes every number of a report again from the raw messages, and names the first that differs."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sessions.errors import Refused
from sessions.reports.exchange import report_object
from sessions.reports.passive import named_by_digest
from sessions.reports.report import build_report

_PARTS = ("value", "unit", "interval", "version", "status", "lineage")


@dataclass(frozen=True, slots=True)
class Recomputed:
    """A report that its file reproduces.

    Attributes:
        file_sha256: Digest of the file.
        numbers: How many numbers were made again, bit for bit.
    """

    file_sha256: str
    numbers: int


def verify_report(path_json: Path, path_mcap: Path) -> Recomputed:
    """Make a report again and compare it bit for bit.

    A passive run that the report took off is looked for beside the session, by its digest.

    Args:
        path_json: The report, as ``render_json`` writes it.
        path_mcap: The take or session that it is about.

    Raises:
        Refused: The report cannot be read, is about other files, or a number differs: the first is named.
    """
    written = _read(path_json)
    run = _passive_run(written, path_mcap)
    report = build_report([path_mcap], passive={path_mcap: (run,)} if run else None)
    made: dict[str, Any] = json.loads(json.dumps(report_object(report)))
    digest = str(made["sessions"][0]["file_sha256"])
    claimed = [item for item in written["metrics"] if _digest(item) == digest]
    if not claimed:
        value = f"not about the file {digest[:12]}"
        raise Refused(f"report {path_json.name}", value, "about this file", "name the file of the report")
    again = made["metrics"]
    for one, other in zip(claimed, again, strict=False):
        _compare(path_json.name, one, other)
    if len(claimed) != len(again):
        value, bound = f"{len(claimed)} numbers long", f"{len(again)} numbers long, as the file gives"
        raise Refused(f"report {path_json.name}", value, bound, "make the report again")
    return Recomputed(digest, len(again))


def _passive_run(written: dict[str, Any], path_mcap: Path) -> Path | None:
    """The passive run that the report took off this file, None without one.

    Raises:
        Refused: It is not beside the session.
    """
    with path_mcap.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    for session in written.get("sessions") or ():
        taken = session.get("passive_run_sha256") if isinstance(session, dict) else None
        if isinstance(taken, str) and taken and session.get("file_sha256") == digest:
            return named_by_digest(taken, path_mcap.parent)
    return None


def _compare(name: str, one: dict[str, Any], other: dict[str, Any]) -> None:
    """Refuse the first difference; numbers are equal only to the last bit."""
    if (one.get("name"), one.get("subject")) != (other["name"], other["subject"]):
        value = f"{one.get('name')} of {one.get('subject')}"
        bound = f"{other['name']} of {other['subject']}, as the file gives"
        raise Refused(f"number in report {name}", value, bound, "make the report again")
    for part in _PARTS:
        if one.get(part) != other[part]:
            thing = f"{part} of {other['name']} ({other['subject']}) in report {name}"
            value, bound = json.dumps(one.get(part))[:200], json.dumps(other[part])[:200]
            remedy = "make the report again, and find out who changed it"
            raise Refused(thing, value, f"{bound}, as the file gives", remedy)


def _read(path: Path) -> dict[str, Any]:
    try:
        content: Any = json.loads(path.read_bytes())
    except OSError as error:
        value = f"not readable ({(error.strerror or 'no reason given').lower()})"
        raise Refused(f"report {path.name}", value, "a report as JSON", "check the path") from error
    except ValueError as error:
        raise Refused(f"report {path.name}", "no JSON", "a report as JSON", "name the .json of it") from error
    if not isinstance(content, dict) or not isinstance(content.get("metrics"), list):
        raise Refused(f"report {path.name}", "without metrics", "a report as JSON", "name the .json of it")
    return content


def _digest(item: Any) -> str:
    lineage: Any = item.get("lineage") if isinstance(item, dict) else None
    return str(lineage.get("file_sha256", "")) if isinstance(lineage, dict) else ""
