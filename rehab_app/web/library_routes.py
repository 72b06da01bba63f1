"""Paths of the library: exercises, what is prescribed of them, takes, devices."""

from __future__ import annotations

from collections.abc import Callable

from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from rehab_app.access import Verb
from rehab_app.web.pages import devices, exercises, plans, stations, takes
from rehab_app.web.visit import Visit, action, page


def library_routes() -> list[BaseRoute]:
    """The routes; a path that names an exercise takes whatever the clinic called it."""

    def shows(path: str, answer: Callable[[Visit], Response], verb: Verb = "view") -> BaseRoute:
        return Route(path, page(answer, verb), methods=["GET"])

    def does(path: str, answer: Callable[[Visit], Response], verb: Verb) -> BaseRoute:
        return Route(path, action(answer, verb, "/takes"), methods=["POST"])

    return [
        shows("/exercises", exercises.exercises),
        does("/exercises", exercises.add, "prescribe"),
        shows("/exercises/{name:path}", exercises.exercise),
        shows("/exercise-pictures/{name}/{view}/{side}.svg", exercises.picture),
        shows("/prescribe", exercises.prescribe, "prescribe"),
        shows("/patients/{patient}/plan", plans.plan),
        does("/patients/{patient}/plan/item", plans.save_item, "note"),
        does("/patients/{patient}/plan/move", plans.move_item, "note"),
        does("/patients/{patient}/plan/frame", plans.save_frame, "note"),
        shows("/takes", takes.takes),
        shows("/takes/{recording}", takes.take),
        does("/takes/{recording}/approve", takes.approve, "approve"),
        does("/takes/{recording}/withdraw", takes.withdraw, "note"),
        does("/takes/{recording}/retouch", takes.retouch, "record"),
        shows("/takes/{recording}/compare", takes.compare),
        shows("/takes/{recording}/joints/{which}.svg", takes.joints),
        shows("/clinic/devices", devices.devices),
        shows("/clinic/stations", stations.stations),
        shows("/clinic/calibration", devices.calibration),
        shows("/clinic/calibration/board.{kind}", devices.board),
    ]
