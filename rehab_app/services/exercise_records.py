"""What an exercise of the library is; its words are English and are translated where pages show them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from rehab_app.services.plan_items import Part
from robot_iface.types import DIGITS

Purpose: TypeAlias = Literal["opening", "range", "fingers", "thumb", "pinch", "grasp", "dexterity", "own"]


def marked(text: str) -> str:
    """Marks a text of the library for the catalogues of languages; pages translate it."""
    return text


PURPOSES: dict[Purpose, str] = {
    "opening": marked("Opening the hand"),
    "range": marked("Range of motion, tendon glides"),
    "fingers": marked("Single joints and fingers"),
    "thumb": marked("Thumb"),
    "pinch": marked("Pinch"),
    "grasp": marked("Grasp and release"),
    "dexterity": marked("Dexterity and rhythm"),
    "own": marked("The clinic's own"),
}


@dataclass(frozen=True, slots=True)
class Dose:
    """What is suggested where a therapist begins to prescribe: a proposal, to be changed.

    Attributes:
        repetitions: How many times.
        minutes: How long at most.
        hold_s: Time held at the end of each repetition.
        mode: Therapy mode.
        part: Step of the session.
    """

    repetitions: int = 10
    minutes: float = 5.0
    hold_s: float = 0.5
    mode: str = "assistive"
    part: Part = "active"


@dataclass(frozen=True, slots=True, kw_only=True)
class Exercise:
    """One exercise.

    Attributes:
        name: What takes and plans call it.
        words: Its name on the screen.
        purposes: What it may be looked for by.
        purpose: What it is for, one sentence.
        instructions: What the patient does, one sentence a step.
        digits: Digits that it moves.
        joints: What it aims at, in words.
        cautions: When to be careful.
        dose: What is suggested.
        start: Posture that it begins with, empty where nothing is drawn.
        end: Posture that it goes to.
        view: From where it is seen best.
        own: Whether the clinic added it.
    """

    name: str
    words: str
    purposes: tuple[Purpose, ...]
    purpose: str
    instructions: tuple[str, ...] = ()
    digits: tuple[str, ...] = tuple(DIGITS)
    joints: str = ""
    cautions: tuple[str, ...] = ()
    dose: Dose = Dose()
    start: str = ""
    end: str = ""
    view: Literal["palm", "side"] = "side"
    own: bool = False
