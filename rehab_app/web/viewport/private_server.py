"""A viser server that only the gateway can find.

viser checks neither sign-in nor origin: any page that a browser on this machine has open may speak to any
server on 127.0.0.1. So the viewports listen on a loopback address and a port that are drawn at every start
(24 and 15 bits), which a page cannot guess and cannot search in a useful time; the gateway is the way in.
"""

from __future__ import annotations

import contextlib
import io
import secrets

import viser

from rehab_app.errors import Refused

LOOPBACK = ".".join(["127", *(str(1 + secrets.randbelow(254)) for _ in range(3))])
"""Address of all viewports of this process."""


class PrivateServer(viser.ViserServer):
    """A viser server on the private loopback address that never opens a public tunnel.

    Args:
        label: Title of the browser tab.

    Raises:
        Refused: It did not get a port.
    """

    def __init__(self, label: str) -> None:
        with _hushed():
            super().__init__(host=LOOPBACK, port=0, label=label, verbose=False)
        if not 0 < self.get_port() < 65536:
            raise Refused("viewport port", str(self.get_port()), "a free loopback port", "free some ports")

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: a client's message could otherwise publish the clinic's screen."""
        return None

    def stop(self) -> None:
        """Close the server."""
        with _hushed():
            super().stop()


def _hushed() -> contextlib.redirect_stdout[io.StringIO]:
    """Keep viser from printing an address that no person should open."""
    return contextlib.redirect_stdout(io.StringIO())
