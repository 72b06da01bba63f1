"""The clinic's screen: shell pages, the stop, and the filtering gateway to the 3-D viewports."""

from rehab_app.web.app import create_app
from rehab_app.web.server import serve

__all__ = ["create_app", "serve"]
