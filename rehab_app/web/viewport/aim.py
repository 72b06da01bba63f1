"""The review's own choice of a target grip, in its panel."""

from __future__ import annotations

import math
from typing import Any

import viser

from rehab_app.errors import Refused
from rehab_app.grasp.grip import GRIPS
from rehab_app.services.grip_finder import FoundGrip, GripFinder
from rehab_app.services.grip_target import LARGEST_MM, SMALLEST_MM, GripChoice, choice_fields, grip_choice
from rehab_app.web.language import _, marked
from robot_iface.kinematics import HandGeometry

_OBJECTS = {
    "none": marked("None"),
    "cylinder": marked("Cylinder"),
    "ball": marked("Ball"),
    "box": marked("Box"),
}


class Aim:
    """Widgets that choose a target grip; whoever draws asks for what is known of it.

    Args:
        server: The viser server; the widgets go into its panel.
        choice: What is chosen at first, such as the grip that a recording aimed at; None for nothing.
    """

    def __init__(self, server: viser.ViserServer, choice: GripChoice | None = None) -> None:
        self._finder = GripFinder()
        self._choice = choice
        self._complaint = ""
        gui, first = server.gui, choice_fields(choice)
        # kept, as choices come on threads that know no language
        self._objects = {_(word): name for name, word in _OBJECTS.items()}
        self._grips = {_(name.capitalize()): name for name in GRIPS}
        self._sizes = {"box": _("Thickness [mm]"), "": _("Diameter [mm]")}
        with gui.add_folder(_("Target grip"), expand_by_default=choice is not None):
            self._object: Any = gui.add_dropdown(
                _("Object"), tuple(self._objects), initial_value=_label(self._objects, first["object"])
            )
            self._size: Any = _millimetres(gui, _("Size [mm]"), first["size"])
            self._width: Any = _millimetres(gui, _("Width [mm]"), first["width"])
            self._grip: Any = gui.add_dropdown(
                _("Grip"), tuple(self._grips), initial_value=_label(self._grips, first["grip"])
            )
        for widget in (self._object, self._size, self._width, self._grip):
            widget.on_update(self._chosen)
        self._fold()

    def found(self, geometry: HandGeometry) -> FoundGrip:
        """What is known of the chosen target for a hand; never waits."""
        if self._complaint:
            return FoundGrip(words=self._complaint, refused=True)
        return self._finder.find(self._choice, geometry)

    def _chosen(self, _: viser.GuiEvent[Any]) -> None:
        """Somebody chose; a client may send anything."""
        try:
            self._choice = grip_choice(
                self._objects.get(str(self._object.value), str(self._object.value)),
                _number(self._size.value),
                self._grips.get(str(self._grip.value), str(self._grip.value)),
                _number(self._width.value),
            )
            self._complaint = ""
        except Refused as refusal:
            self._complaint = str(refusal)
        self._fold()

    def _fold(self) -> None:
        """Show only what the chosen object needs."""
        kind = self._objects.get(str(self._object.value), "none")
        self._size.label = self._sizes.get(kind, self._sizes[""])
        self._size.visible = kind != "none"
        self._width.visible = kind == "box"
        self._grip.visible = kind in ("cylinder", "box")


def _label(words: dict[str, str], name: str) -> str:
    return next(label for label, word in words.items() if word == name)


def _millimetres(gui: Any, label: str, first_mm: str) -> Any:
    """A field for a size; a file may state one that nobody could choose here, which is shown at the bound."""
    shown_mm = min(max(float(first_mm), SMALLEST_MM), LARGEST_MM)
    return gui.add_number(label, shown_mm, min=SMALLEST_MM, max=LARGEST_MM, step=0.5)


def _number(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else math.nan
