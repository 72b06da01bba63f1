"""The one way in which this package refuses: a sentence that a person can act on."""

from __future__ import annotations


class Refused(Exception):
    """Something was refused, and the sentence says what would be accepted.

    Args:
        thing: What was refused, by name ("take 7f3a", "--speed").
        value: The value that was met, as a person would read it.
        bound: What would have been accepted.
        remedy: What to do now, as an imperative.
    """

    def __init__(self, thing: str, value: str, bound: str, remedy: str) -> None:
        super().__init__(f"{thing} is {value}, but must be {bound}: {remedy}.")
        self.thing = thing
        self.value = value
        self.bound = bound
        self.remedy = remedy


class NoAnswer(Refused):
    """The data base does not answer: what was asked of it may be asked again later, unchanged."""
