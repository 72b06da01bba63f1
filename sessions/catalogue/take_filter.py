"""Which takes are wanted."""

from __future__ import annotations

from dataclasses import dataclass

from sessions.catalogue.records import Take


@dataclass(frozen=True, slots=True)
class TakeWord:
    """A word that somebody typed, and what of the catalogue it stands for.

    Attributes:
        text: The word as names are compared, see ``sessions.catalogue.search``.
        exercises: Exercises whose words on the screen hold it.
        sides: Sides whose words on the screen hold it.
    """

    text: str
    exercises: tuple[str, ...] = ()
    sides: tuple[str, ...] = ()

    def fits(self, take: Take) -> bool:
        """Whether it means this take; the name of the person is known to the catalogue only."""
        by_text = take.id.startswith(self.text) or self.text == take.subject_id.casefold()
        return by_text or take.exercise in self.exercises or take.side in self.sides


@dataclass(frozen=True, slots=True, kw_only=True)
class TakeFilter:
    """Takes must fit all that is given; what is empty or None fits every take.

    Attributes:
        exercise: Name of the exercise.
        side: Side of the recorded hand.
        approved: Whether an approval holds.
        subject: Pseudonym of the person whose hand it is.
        parent: Id of the take that it was made from.
        words: Each must mean the take by its exercise, side, beginning of its id, or whose hand it is.
    """

    exercise: str = ""
    side: str = ""
    approved: bool | None = None
    subject: str = ""
    parent: str = ""
    words: tuple[TakeWord, ...] = ()

    def fits(self, take: Take) -> bool:
        """Whether a take fits that nobody has approved."""
        wanted = (self.exercise, self.side, self.subject, self.parent)
        found = (take.exercise, take.side, take.subject_id, take.parent)
        plain = all(not one or one == other for one, other in zip(wanted, found, strict=True))
        return plain and not self.approved and all(word.fits(take) for word in self.words)
