"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

Json: TypeAlias = Annotated[bool, typer.Option("--json", help="One JSON object on stdout, SI units.")]
Data: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--data", help="Clinic folder (else REHAB_DATA, else the user's data folder).", show_default=False
    ),
]
Out: TypeAlias = Annotated[Path | None, typer.Option("--out", help="File to make.", show_default=False)]
Seed: TypeAlias = Annotated[int, typer.Option("--seed", help="Seed of everything random.")]
Take: TypeAlias = Annotated[str, typer.Argument(metavar="TAKE", help="Path or catalogue id of a take.")]
Side: TypeAlias = Annotated[str, typer.Option("--side", help="left or right.")]
