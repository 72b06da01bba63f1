"""How far a station's clock is off the data base's, which all stations of a clinic share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sessions.catalogue import ClockTrip

TRIPS = 8
MOST_OFF_S = 2.0
"""Beyond this, times of two stations contradict each other where a person reads them."""


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """A station's clock minus that of the data base.

    Attributes:
        offset_ns: The difference; above 0 the station is ahead.
        uncertainty_ns: It is known to within this much either way.
    """

    offset_ns: int
    uncertainty_ns: int


def offset_of(trips: Sequence[ClockTrip]) -> ClockOffset:
    """The offset by the quickest of some questions, whose answer is the least uncertain.

    The other clock was read somewhere between question and answer; half of the round trip is the bound of
    what the middle may be wrong by, however unequal the two ways are.

    Args:
        trips: Questions to the data base's clock; none where it is this machine's own.
    """
    if not trips:
        return ClockOffset(0, 0)
    best = min(trips, key=lambda one: one.trip_ns)
    half_ns = (best.trip_ns + 1) // 2
    return ClockOffset(best.asked_utc_ns + half_ns - best.there_utc_ns, half_ns)


def clock_warning(name: str, offset: ClockOffset) -> str:
    """One sentence where a clock is off by more than 2 s for certain, else "".

    Args:
        name: Name of the station.
        offset: Of its clock.
    """
    off_s = offset.offset_ns / 1e9
    if abs(off_s) - offset.uncertainty_ns / 1e9 <= MOST_OFF_S:
        return ""
    way = "ahead of" if off_s > 0 else "behind"
    return (
        f"The clock of station {name} is {abs(off_s):.1f} s {way} the data base's: "
        "let both follow a time server (timedatectl set-ntp true)."
    )


def offset_words(offset: ClockOffset) -> str:
    """The offset in ms with its uncertainty, such as "+12.3 ± 0.4 ms off the data base's"."""
    if not offset.uncertainty_ns:
        return "the data base's own"  # a file of that machine
    return f"{offset.offset_ns / 1e6:+.1f} ± {offset.uncertainty_ns / 1e6:.1f} ms off the data base's"
