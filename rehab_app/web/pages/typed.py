"""A form that is read field by field: what is refused stands beside its field, what was typed is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

from rehab_app.errors import Refused, RobotRefused
from rehab_app.web.refusals import sentence_of
from rehab_app.web.visit import Visit

__all__ = ["Typed", "sentence_of"]

V = TypeVar("V")


class Typed:
    """What somebody typed into a form.

    Args:
        visit: The request.
        names: Fields of the form.

    Attributes:
        values: Text of each field, trimmed; "" where it was not sent.
        problems: Sentence by field, in the order in which they were found; the field "" is the whole form.
    """

    def __init__(self, visit: Visit, names: Iterable[str]) -> None:
        self.values: dict[str, str] = {name: visit.asked(name).replace("\r\n", "\n") for name in names}
        self.problems: dict[str, str] = {}

    def read(self, name: str, make: Callable[[str], V], instead: V) -> V:
        """What a field stands for; where it is refused, ``instead``, and its sentence is kept.

        Args:
            name: Field.
            make: Makes the value of the text, or refuses.
            instead: Stands in for it until it is corrected.
        """
        try:
            return make(self.values[name])
        except (Refused, RobotRefused) as refusal:
            self.problems.setdefault(name, sentence_of(refusal))
            return instead

    def refuse(self, refusal: Refused | RobotRefused, fields: Mapping[str, str]) -> None:
        """Keep the sentence of a refusal beside its field.

        Args:
            refusal: From a service.
            fields: Field by the refusal's thing; what is not named stands above the form.
        """
        self.problems.setdefault(fields.get(refusal.thing, ""), sentence_of(refusal))
