"""``retouch``: a new take made of an old one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli.options import By, Data, Json, Out, Take
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.retouching import Slowing


def retouch(
    take: Take,
    reason: Annotated[str, typer.Option("--reason", help="Why; it stands in the new take.")],
    trim: Annotated[
        str | None, typer.Option("--trim", metavar="A:B", help="Keep A to B seconds.", show_default=False)
    ] = None,
    smooth: Annotated[
        float | None,
        typer.Option("--smooth", help="Usual jerk, 5 to 500 rad/s^3: less is smoother.", show_default=False),
    ] = None,
    slow: Annotated[
        list[str] | None,
        typer.Option(
            "--slow", metavar="F[:A:B]", help="F times as long, all or A to B s.", show_default=False
        ),
    ] = None,
    scale: Annotated[
        list[str] | None,
        typer.Option(
            "--scale", metavar="DIGIT=F", help="F times the movement of a digit or joint.", show_default=False
        ),
    ] = None,
    by: By = "",
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Trim, smooth, slow or scale a take into a new one, which somebody has to approve."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.services.retouching import Wish

    output = Output(json)
    wish = Wish(
        trim_s=None if trim is None else _span(trim),
        smooth_rad_s3=smooth,
        slow=tuple(_slowing(text) for text in slow or ()),
        scale=tuple(_scaling(text) for text in scale or ()),
    )
    with open_clinic(data) as clinic:
        row = clinic.retouching.retouch(take, wish, reason, actor=acting(clinic, by), out=out)
    output.say(f"Take {row.id}: {row.duration_s:.1f} s, retouched from {row.parent} by {row.author}.")
    output.say(f"Approve it with: rehab-app approve {row.id} --by NAME")
    output.result(
        {
            "take": row.path if out is None else out,
            "id": row.id,
            "parent": row.parent,
            "author": row.author,
            "reason": row.reason,
            "duration_s": row.duration_s,
            "sha256": row.sha256,
        }
    )


def _span(text: str) -> tuple[float, float]:
    first, _, last = text.partition(":")
    return _number("--trim", text, first, "A:B in seconds"), _number("--trim", text, last, "A:B in seconds")


def _slowing(text: str) -> Slowing:
    from rehab_app.services.retouching import Slowing

    parts = [_number("--slow", text, part, "F or F:A:B, seconds") for part in text.split(":")]
    if len(parts) == 1:
        return Slowing(parts[0])
    if len(parts) == 3:
        return Slowing(parts[0], (parts[1], parts[2]))
    raise _nonsense("--slow", text, "F or F:A:B, seconds")


def _scaling(text: str) -> tuple[str, float]:
    subject, _, factor = text.partition("=")
    return subject, _number("--scale", text, factor, "DIGIT=F, such as index=1.2")


def _number(option: str, text: str, part: str, bound: str) -> float:
    try:
        return float(part)
    except ValueError:
        raise _nonsense(option, text, bound) from None


def _nonsense(option: str, text: str, bound: str) -> Exception:
    from rehab_app.errors import Refused

    return Refused(option, repr(text[:40]), bound, "type it so")
