"""Retouched takes: trimmed, smoothed, slowed, scaled; each a new take with parent, author and reason."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import msgspec

from rehab_app import __version__
from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.recording.take import HandMotion
from rehab_app.services import storage
from rehab_app.services.rows import TakeRow
from rehab_app.services.takes import Lineage, Takes
from rehab_app.therapy.retouch import Operation, Scale, Slow, Smooth, Trim, retouch
from rehab_app.therapy.retouch_file import write_retouched

_LONGEST_REASON = 500


@dataclass(frozen=True, slots=True)
class Slowing:
    """A part to be slowed.

    Attributes:
        factor: How many times as long it takes.
        span_s: From when to when; None for the whole take.
    """

    factor: float
    span_s: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Wish:
    """What is to be done to a take, in this order.

    Attributes:
        trim_s: From when to when to keep; None for all of it.
        smooth_rad_s3: Usual jerk of a joint after smoothing; None to leave it.
        slow: Parts to slow; times are those after trimming, each later than the one before.
        scale: Digits or joints with the factor of their movement.
    """

    trim_s: tuple[float, float] | None = None
    smooth_rad_s3: float | None = None
    slow: tuple[Slowing, ...] = ()
    scale: tuple[tuple[str, float], ...] = ()


class Retouching:
    """Makes new takes of old ones.

    Args:
        folder: The clinic folder.
        takes: Where takes are found and entered.
    """

    def __init__(self, folder: ClinicFolder, takes: Takes) -> None:
        self._folder = folder
        self._takes = takes

    def retouch(
        self, take: str | Path, wish: Wish, reason: str, *, actor: Account, out: Path | None = None
    ) -> TakeRow:
        """Make a new take of an old one, which stays as it is. Nobody has approved the new one yet.

        Args:
            take: Path or catalogue id.
            wish: What to do.
            reason: Why.
            actor: Who does it (verb "record").
            out: A copy for the user.

        Raises:
            Refused: The actor may not record, there is no such take or it was changed, nothing is to be done,
                something is out of bounds, or no reason is given.
        """
        require(actor, "record")
        storage.check_out(out)
        if len(reason) > _LONGEST_REASON:
            bound = f"at most {_LONGEST_REASON} characters"
            raise Refused("reason for the retouch", f"{len(reason)} characters long", bound, "shorten it")
        parent = self._takes.get(take)
        self._takes.check_unchanged(parent)
        operations = operations_of(wish, self._takes.motion(parent.id))
        target = storage.new_file(self._folder.takes)
        write_retouched(parent.path, target, operations, actor.name, reason.strip(), __version__)
        done = msgspec.json.encode(operations).decode()
        row = self._takes.enter(
            target, "retouch", actor, Lineage(parent.id, actor.name, reason.strip(), done)
        )
        if out is not None:
            storage.copy_sealed(row.path, out, row.sha256)
        return row


def operations_of(wish: Wish, motion: HandMotion) -> tuple[Operation, ...]:
    """The operations of a wish on a movement.

    Raises:
        Refused: The part to keep is not in the take.
    """
    cut: tuple[Operation, ...] = () if wish.trim_s is None else (Trim(*wish.trim_s),)
    length_s = float((retouch(motion, cut).motion if cut else motion).t_s[-1])
    smoothed = () if wish.smooth_rad_s3 is None else (Smooth(wish.smooth_rad_s3),)
    # the last part first: a part that was slowed moves whatever comes after it
    slowed = [Slow(part.factor, *(part.span_s or (0.0, length_s))) for part in reversed(wish.slow)]
    scaled = [Scale(subject, factor) for subject, factor in wish.scale]
    return (*cut, *smoothed, *slowed, *scaled)
