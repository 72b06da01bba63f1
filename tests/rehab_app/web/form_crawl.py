"""Finds every form of the pages as a browser does: fields, choices, what is filled in."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = ("submit", "button", "image", "reset")


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a form: its kind ("text", "textarea", "select", ...), what it holds, its marks."""

    name: str
    kind: str
    value: str
    required: bool = False
    numeric: bool = False
    told: str = ""
    choices: tuple[str, ...] = ()

    @property
    def typed(self):
        return self.kind in ("text", "search", "textarea")


@dataclass(slots=True)
class Form:
    """A form of a page."""

    page: str
    action: str
    method: str
    fields: list[Field] = field(default_factory=list)

    @property
    def path(self):
        return self.action.split("#")[0]

    def filled(self):
        """What a browser sends when nothing is touched; the first choice of radio buttons, ticks left out."""
        return {one.name: one.value for one in self.fields if one.kind != "checkbox"}


class Reader(HTMLParser):
    """Reads the forms of one page."""

    def __init__(self, page):
        super().__init__()
        self.page, self.forms, self._form, self._area, self._choice = page, [], None, None, None

    def handle_starttag(self, tag, attributes):
        held = {name: value or "" for name, value in attributes}
        if tag == "form":
            self._form = Form(self.page, held.get("action", ""), held.get("method", "get").lower())
        elif self._form is None or ("name" not in held and tag != "option"):
            return
        elif tag == "input" and held.get("type") not in VOID:
            self._input(held)
        elif tag == "button" and held.get("value"):
            self._form.fields.append(Field(held["name"], "button", held["value"]))
        elif tag == "textarea":
            self._area = [held["name"], "required" in held, ""]
        elif tag == "select":
            self._choice = [held["name"], "required" in held, None, []]
        elif tag == "option" and self._choice is not None:
            self._choice[3].append(held.get("value", ""))
            if "selected" in held or self._choice[2] is None:
                self._choice[2] = held.get("value", "")

    def _input(self, held):
        kind = held.get("type", "text")
        if (
            kind == "radio"
            and "checked" not in held
            and any(o.name == held["name"] for o in self._form.fields)
        ):
            return
        numeric = held.get("inputmode") in ("decimal", "numeric") or kind == "number"
        told = held.get("title", "") + held.get("aria-describedby", "")
        required = "required" in held
        self._form.fields.append(Field(held["name"], kind, held.get("value", ""), required, numeric, told))

    def handle_data(self, text):
        if self._area is not None:
            self._area[2] += text

    def handle_endtag(self, tag):
        if tag == "form" and self._form is not None:
            self._form.fields = [one for one in self._form.fields if one.name != "form_token"]
            self.forms.append(self._form)
            self._form = None
        elif tag == "textarea" and self._area is not None:
            name, required, value = self._area
            self._form.fields.append(Field(name, "textarea", value, required))
            self._area = None
        elif tag == "select" and self._choice is not None:
            name, required, value, choices = self._choice
            kept = Field(name, "select", value or "", required, choices=tuple(choices))
            self._form.fields.append(kept)
            self._choice = None


def forms_of(page, html):
    """The forms of a page that send something.

    Args:
        page: Its path.
        html: What the server answered.
    """
    reader = Reader(page)
    reader.feed(html)
    return [form for form in reader.forms if form.method == "post"]
