"""Who sits before a browser: its ticket, the sign-in that the server remembers, and whether it is covered."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.requests import HTTPConnection
from starlette.responses import Response

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.web.signing import Ticket
from rehab_app.web.site import Site

COOKIE = "rehab_sign_in"
_REMEMBERED_S = 14 * 24 * 3600  # longer than it holds: an ended sign-in still says whose form is kept


@dataclass(frozen=True, slots=True)
class Present:
    """Somebody whose sign-in holds.

    Attributes:
        account: Who.
        ticket: Their sign-in.
        locked: Whether nobody used it for too long: then it opens nothing until the password is given again.
    """

    account: Account
    ticket: Ticket
    locked: bool


def ticket_of(site: Site, connection: HTTPConnection) -> Ticket | None:
    """The sign-in that a request claims; asks no data base, so it only names people and opens nothing."""
    return site.seal.read(connection.cookies.get(COOKIE))


def present(site: Site, connection: HTTPConnection) -> Present | None:
    """Who is there, covered or not; None where nobody is signed in."""
    ticket = ticket_of(site, connection)
    if ticket is None:
        return None
    held = site.clinic.accounts.sign_ins.look(ticket.name, ticket.digest)
    if held is None:
        return None
    try:
        account = site.accounts.get(ticket.name)
    except Refused:
        return None
    return Present(account, ticket, held.locked and covers(account))


def account_of(site: Site, connection: HTTPConnection) -> Account | None:
    """The account of a request, None where nobody is signed in or the sign-in is locked."""
    there = present(site, connection)
    return None if there is None or there.locked else there.account


def covers(account: Account) -> bool:
    """Whether the pages of an account are covered when idle: the patient's screen stays, it opens nothing."""
    return account.role != "patient"


def is_secure(connection: HTTPConnection) -> bool:
    """Whether the connection is encrypted, so that cookies may insist on it."""
    return connection.url.scheme in ("https", "wss")


def give_cookie(answer: Response, name: str, value: str, seconds: int, connection: HTTPConnection) -> None:
    """Set a cookie that no script reads, no other site sends, and, given over TLS, no plain HTTP carries."""
    answer.set_cookie(
        name, value, max_age=seconds, httponly=True, samesite="strict", secure=is_secure(connection)
    )


def take_cookie(answer: Response, name: str, connection: HTTPConnection) -> None:
    """Take a cookie back."""
    answer.delete_cookie(name, httponly=True, samesite="strict", secure=is_secure(connection))


def sign_in_cookie(site: Site, answer: Response, name: str, connection: HTTPConnection) -> str:
    """Begin a sign-in, give the browser its cookie, and end the one that it had: a ticket never outlives it.

    Returns:
        Token of the forms of the new sign-in.
    """
    before = site.seal.read_old(connection.cookies.get(COOKIE))
    if before is not None:
        site.clinic.accounts.sign_ins.end(before.name, before.digest)
    cookie = site.begin(name)
    give_cookie(answer, COOKIE, cookie, _REMEMBERED_S, connection)
    ticket = site.seal.read_old(cookie)
    return "" if ticket is None else site.seal.form_token(ticket)
