"""Files: report, info, verify, recover."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

from rehab_app.cli.options import Data, Json, Out
from rehab_app.cli.output import Output

Recording: TypeAlias = Annotated[
    str, typer.Argument(metavar="SESSION", help="Path or catalogue id of a session or take.")
]


def report(
    sessions: Annotated[
        list[str], typer.Argument(metavar="SESSION...", help="Paths or catalogue ids of sessions or takes.")
    ],
    formats: Annotated[str, typer.Option("--format", help="html, json, or both with a comma.")] = "html,json",
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder, or file for one format.", show_default=False)
    ] = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Report sessions or takes."""
    import msgspec

    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    wanted = [name.strip() for name in formats.split(",") if name.strip()]
    with open_clinic(data) as clinic:
        made = clinic.reports.report(sessions, wanted, out, actor=CONSOLE)
        content: dict[str, Any] = msgspec.json.decode(clinic.reports.json(*sessions)) if json else {}
    for path in made:
        output.say(f"Report: {path}")
    output.result({**content, "files": list(made)})


def info(session: Recording, data: Data = None, json: Json = False) -> None:
    """Say what a session file holds."""
    from rehab_app.cli.locate import locate
    from sessions.store import info as describe

    output = Output(json)
    found = describe(locate(session, data))
    header = found.header
    output.say(
        f"{found.path.name}: {header.kind} of {header.exercise} ({header.side} hand), "
        f"{found.duration_s:.1f} s, {found.bytes / 1e6:.2f} MB, "
        f"by {header.source}, software {header.software_version}."
    )
    for topic in found.topics:
        output.say(f"  {topic.name}  {topic.records} x {topic.schema}")
    output.result(
        {
            "path": found.path,
            "kind": header.kind,
            "session_id": header.session_id,
            "subject_id": header.subject_id,
            "side": header.side,
            "exercise": header.exercise,
            "source": header.source,
            "software_version": header.software_version,
            "format_version": header.format_version,
            "parents": list(header.parents),
            "duration_s": found.duration_s,
            "bytes": found.bytes,
            "topics": {topic.name: topic.records for topic in found.topics},
            "events": found.events,
            "recovered": found.recovered,
            "sha256": found.sha256,
        }
    )


def verify(session: Recording, data: Data = None, json: Json = False) -> None:
    """Prove that a session file is whole: checksums, records, digest."""
    from rehab_app.cli.locate import locate
    from sessions.store import verify as prove

    output = Output(json)
    proof = prove(locate(session, data))
    beside = "as noted beside it" if proof.digest_noted else "no digest is noted beside it"
    output.say(f"{proof.path.name} is whole: {proof.chunks} chunks, SHA-256 {proof.sha256} ({beside}).")
    output.result(
        {
            "path": proof.path,
            "ok": True,
            "sha256": proof.sha256,
            "digest_noted": proof.digest_noted,
            "bytes": proof.bytes,
            "chunks": proof.chunks,
            "records": proof.records,
        }
    )


def recover(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A .partial.mcap or a cut session file.")],
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Restore what a session file holds that was never sealed."""
    del data  # every command takes it; this one touches no clinic folder
    from sessions.store import recover as restore

    output = Output(json)
    restored = restore(file, out)
    sealed = restored.sealed
    lost = f"{restored.lost_records} records and {restored.lost_chunks} chunks could not be read"
    output.say(f"Restored {restored.records} records as {sealed.path}; {lost}. SHA-256 {sealed.sha256}.")
    output.result(
        {
            "path": sealed.path,
            "sha256": sealed.sha256,
            "bytes": sealed.bytes,
            "records": restored.records,
            "lost_records": restored.lost_records,
            "lost_chunks": restored.lost_chunks,
        }
    )
