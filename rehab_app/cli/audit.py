"""The proof that the audit is whole."""

from __future__ import annotations

from pathlib import Path

from rehab_app.cli.output import Output
from rehab_app.errors import Refused


def verify_audit(folder: Path | None, output: Output) -> None:
    """Follow the audit's hash chain; say its rows and its head.

    Args:
        folder: Clinic folder, None for the default.
        output: Where it is said.

    Raises:
        Refused: A row was changed, removed or slipped in.
    """
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    with open_clinic(folder) as clinic:
        state = clinic.audit.state(CONSOLE)
    if state.problem:
        raise Refused(
            "audit",
            f"broken: {state.problem}",
            "an unbroken chain",
            "restore the data base from a backup and find out who changed it",
        )
    output.say(f"The audit is unbroken: {state.rows:,} rows, head {state.head or 'none'}.")
    output.result({"ok": True, "rows": state.rows, "head": state.head})
