"""The clinic: a card for each part that exists and that the visitor may open."""

from __future__ import annotations

from starlette.responses import Response
from starlette.routing import Route

from rehab_app.access import Verb
from rehab_app.web.language import marked
from rehab_app.web.pages.first_steps import first_steps
from rehab_app.web.visit import Visit

_CARDS: tuple[tuple[str, Verb, str, str], ...] = (
    ("/account", "stop", marked("My account"), marked("Your password, and where you are signed in.")),
    ("/clinic/users", "manage_users", marked("Users"), marked("Who may sign in, and as what.")),
    ("/clinic/audit", "audit", marked("Audit"), marked("Who did what, in an unbroken chain.")),
    ("/clinic/devices", "view", marked("Devices"), marked("Robots and cameras, and what is known of them.")),
    ("/clinic/calibration", "view", marked("Calibration"), marked("How well the cameras measure.")),
    ("/clinic/stations", "view", marked("Stations"), marked("Each room's machine, and who is treated.")),
    ("/clinic/backup", "backup", marked("Backup"), marked("Backups, restore, and how long data is kept.")),
    ("/clinic/settings", "manage_users", marked("Settings"), marked("What holds for the whole clinic.")),
    ("/help", "view", marked("Help"), marked("First steps, and what the words mean.")),
)


def home(visit: Visit) -> Response:
    """The page."""
    paths = {route.path for route in visit.request.app.routes if isinstance(route, Route)}
    cards = [card for card in _CARDS if card[0] in paths and visit.account.may(card[1])]
    return visit.page("clinic.html.j2", cards=cards, first=first_steps(visit))
