"""The 3-D pictures: live and review. They show and never move anything."""

from rehab_app.web.viewport.live import LiveViewport
from rehab_app.web.viewport.private_server import LOOPBACK
from rehab_app.web.viewport.review import PAIRED, ReviewViewports

__all__ = ["LOOPBACK", "PAIRED", "LiveViewport", "ReviewViewports"]
