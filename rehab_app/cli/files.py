"""Files: info, verify, recover."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from rehab_app.cli.options import Data, Json, Out
from rehab_app.cli.output import Output

Recording: TypeAlias = Annotated[
    str, typer.Argument(metavar="SESSION", help="Path or catalogue id of a session or take.")
]


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


def verify(
    session: Annotated[
        str,
        typer.Argument(
            metavar="SESSION", help="Path or catalogue id of a session or take.", show_default=False
        ),
    ] = "",
    audit: Annotated[bool, typer.Option("--audit", help="The clinic's audit instead of a file.")] = False,
    data: Data = None,
    json: Json = False,
) -> None:
    """Prove that a session file is whole (checksums, records, digest), or the audit's hash chain."""
    from rehab_app.cli.audit import verify_audit
    from rehab_app.cli.locate import locate
    from sessions.store import verify as prove

    output = Output(json)
    if audit == bool(session):
        raise typer.BadParameter("name a session or take, or give --audit")
    if audit:
        verify_audit(data, output)
        return
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
