"""The library of exercises: the starter set, the clinic's own ones, and their pictures."""

from __future__ import annotations

import unicodedata
from functools import lru_cache

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.hand.exercise_postures import posture_rad
from rehab_app.services.audit import Audit
from rehab_app.services.exercise_drawing import View, draw_pair
from rehab_app.services.exercise_glides import GLIDES
from rehab_app.services.exercise_records import PURPOSES, Exercise
from rehab_app.services.exercise_tasks import TASKS
from rehab_app.services.plain_text import many_lines, needed, one_line
from sessions.catalogue import Catalogue
from sessions.catalogue import Exercise as OwnExercise
from sessions.records import Side

STARTERS = (*GLIDES, *TASKS)
_LONGEST_NAME = 60
_LONGEST_DESCRIPTION = 2000


class Exercises:
    """The library.

    Args:
        catalogue: Where the clinic's own exercises are kept.
        audit: Where additions are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def list(self, words: str = "", purpose: str = "") -> tuple[Exercise, ...]:
        """Exercises that hold every word and serve the purpose; the starter set first.

        Raises:
            Refused: There is no such purpose.
        """
        if purpose and purpose not in PURPOSES:
            raise Refused("purpose", repr(purpose[:40]), "one of " + ", ".join(PURPOSES), "choose one")
        return tuple(
            one
            for one in (*STARTERS, *self._own())
            if (not purpose or purpose in one.purposes) and holds(_searched(one), words)
        )

    def get(self, name: str) -> Exercise:
        """One exercise.

        Raises:
            Refused: There is none of that name.
        """
        for one in (*STARTERS, *self._own()):
            if one.name == name:
                return one
        raise Refused("exercise", repr(name[:40]), "one of the library", "choose it from the list, or add it")

    def words(self, name: str) -> str:
        """An exercise's name on the screen; a name that the library does not know is shown as it is."""
        found = next((one.words for one in STARTERS if one.name == name), "")
        return found or name.replace("_", " ")

    def add(self, actor: Account, name: str, description: str) -> Exercise:
        """Add an exercise of the clinic's own, or describe it anew.

        Args:
            actor: Who adds (verb "prescribe").
            name: Its name, 1 to 60 characters.
            description: What it is for and how it is done.

        Raises:
            Refused: The actor may not, the name is one of the starter set, or a text is too long or empty.
        """
        require(actor, "prescribe")
        plain = needed("name of the exercise", one_line("name of the exercise", name, _LONGEST_NAME))
        told = many_lines("description of the exercise", description, _LONGEST_DESCRIPTION)
        known = {_folded(text) for one in STARTERS for text in (one.name, one.words)}
        if _folded(plain) in known:
            raise Refused("name of the exercise", repr(plain), "a new one", "use the one of the library")
        needed("description of the exercise", told)
        kept = self._catalogue.add_exercise(OwnExercise(name=plain, description=told))
        self._audit.note(actor, "add exercise", kept.name)
        return _own(kept)

    def picture(self, name: str, view: str, side: str) -> str:
        """Start and end posture of an exercise, drawn by the hand's own kinematics.

        Args:
            name: The exercise.
            view: "palm" or "side".
            side: Side of the hand.

        Returns:
            An SVG file.

        Raises:
            Refused: There is no such exercise, or nothing is drawn of it from there.
        """
        one = self.get(name)
        seen: View | None = "palm" if view == "palm" else "side" if view == "side" else None
        hand: Side | None = "left" if side == "left" else "right" if side == "right" else None
        if not one.start or seen is None or hand is None:
            raise Refused(
                f"picture of {one.name}",
                f"{view[:20]!r} view of the {side[:20]!r} hand",
                "palm or side view of the left or right hand, of the starter set",
                "choose another picture",
            )
        return _drawn(one.start, one.end, seen, hand, one.digits)

    def _own(self) -> tuple[Exercise, ...]:
        known = {one.name for one in STARTERS}
        return tuple(_own(kept) for kept in self._catalogue.exercises() if kept.name not in known)


@lru_cache(maxsize=128)
def _drawn(start: str, end: str, view: View, side: Side, digits: tuple[str, ...]) -> str:
    return draw_pair(posture_rad(start), posture_rad(end), view, side, digits)


def _own(kept: OwnExercise) -> Exercise:
    return Exercise(
        name=kept.name, words=kept.name, purposes=("own",), purpose=kept.description, digits=(), own=True
    )


def _searched(one: Exercise) -> str:
    parts = (one.name, one.words, one.purpose, one.joints, *one.instructions, *one.digits)
    return " ".join(parts)


def holds(text: str, words: str) -> bool:
    """Whether a text holds every word that was typed; accents and capitals do not matter."""
    folded = _folded(text)
    return all(word in folded for word in _folded(words).split())


def _folded(text: str) -> str:
    """Without accents and capitals."""
    spread = unicodedata.normalize("NFKD", text.casefold())
    return "".join(one for one in spread if not unicodedata.combining(one)).replace("_", " ")
