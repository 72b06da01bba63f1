"""One line of the table that ``make bench-motion`` prints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """A figure beside what it must and should be.

    Attributes:
        what: What was measured.
        must: Bound that must hold, as a phrase; empty where the figure stands beside another.
        aim: Bound that is wished for, as a phrase.
        measured: The figure as a phrase.
        holds: Whether the must holds.
    """

    what: str
    must: str
    aim: str
    measured: str
    holds: bool = True


def at_most(what: str, value: float, must: float, aim: float | None = None, unit: str = "") -> Row:
    """A row for a figure with an upper bound."""
    wished = "" if aim is None else f"{aim:g}{unit}"
    return Row(what, f"<= {must:g}{unit}", wished, f"{value:.3g}{unit}", value <= must)


def at_least(what: str, value: float, must: float, aim: float | None = None, unit: str = "") -> Row:
    """A row for a figure with a lower bound."""
    wished = "" if aim is None else f"{aim:g}{unit}"
    return Row(what, f">= {must:g}{unit}", wished, f"{value:.3g}{unit}", value >= must)


def beside(what: str, measured: str) -> Row:
    """A row that only stands beside others: a peer, or a figure without a bound."""
    return Row(what, "", "", measured)


def lines(rows: Iterable[Row]) -> list[str]:
    """The rows as a table in Markdown."""
    head = ["| what | must | aim | measured |", "|---|---|---|---|"]
    short = {True: "", False: " **falls short**"}
    return head + [
        f"| {row.what} | {row.must or '-'} | {row.aim or '-'} | {row.measured}{short[row.holds]} |"
        for row in rows
    ]
