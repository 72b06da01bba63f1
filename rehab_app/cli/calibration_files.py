"""Boards to print, and the calibrations that the clinic keeps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli.calibrate import BoardSpec, Dictionary, Marker, Square, calibrate
from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.calibration import CalibratedCamera


@calibrate.command("board")
def board(
    out: Annotated[Path, typer.Option("--out", help="File to make: .pdf, .svg or .png.")],
    board: BoardSpec = "9x6",
    square: Square = 0.025,
    marker: Marker = None,
    dictionary: Dictionary = "4x4_50",
    paper: Annotated[str, typer.Option("--paper", help="A4 to A0 or letter; else the smallest.")] = "",
    json: Json = False,
    data: Data = None,
) -> None:
    """Write a board to print at its true size."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.calibration import parse_board
    from rehab_app.calibration.board_print import SUFFIXES, draw_board, write_board
    from rehab_app.calibration.files import check_target

    output = Output(json)
    check_target(out, SUFFIXES)
    used = parse_board(board, square, marker, dictionary)
    drawing = draw_board(used, paper)
    write_board(drawing, out)
    page = f"{1e3 * drawing.width_m:g} x {1e3 * drawing.height_m:g} mm"
    output.say(f"{used.description} on {page}: {out}. Print at 100 %, glue it flat, measure the ruler.")
    output.result(
        {
            "file": out,
            "board": used.description,
            "columns": used.columns,
            "rows": used.rows,
            "square_m": used.square_m,
            "page_m": [drawing.width_m, drawing.height_m],
        }
    )


@calibrate.command("list")
def list_calibrations(
    camera: Annotated[str, typer.Option("--camera", help="Of this camera only.")] = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """List the calibrations that are kept, newest first."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        rows = clinic.calibrations.list(camera)
    for row in rows:
        output.say(f"{row.digest[:12]}  {row.camera}  {row.verdict}")
    output.result(
        {
            "calibrations": [
                {
                    "digest": row.digest,
                    "camera": row.camera,
                    "verdict": row.verdict,
                    "created_utc_ns": row.created_utc_ns,
                }
                for row in rows
            ]
        }
    )


@calibrate.command("show")
def show(
    calibration: Annotated[
        str, typer.Argument(metavar="CALIBRATION", help="A file, a digest, or the id of a camera.")
    ],
    data: Data = None,
    json: Json = False,
) -> None:
    """Say what a calibration holds: that of a file, of a digest, or a camera's current one."""
    from rehab_app.cli.calibration_output import say_camera

    output = Output(json)
    found = _found(calibration, data)
    say_camera(output, found)
    output.result({**found.table(), "digest": found.digest})


def _found(named: str, data: Path | None) -> CalibratedCamera:
    from rehab_app.bootstrap import open_clinic
    from rehab_app.calibration import load_camera
    from rehab_app.services.storage import is_path

    if is_path(named):
        return load_camera(Path(named))
    with open_clinic(data) as clinic:
        return clinic.calibrations.current(named) or clinic.calibrations.get(named)
