"""Moving a clinic's catalogue to another data base."""

from __future__ import annotations

from rehab_app.access import Account, require
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue
from sessions.catalogue.moving import MovedTable


def move_catalogue(catalogue: Catalogue, audit: Audit, actor: Account, url: str) -> tuple[MovedTable, ...]:
    """Copy every row into an empty data base, whole or not at all; the audit there says so too.

    Args:
        catalogue: The clinic's catalogue; nobody writes to it meanwhile.
        audit: Its audit.
        actor: Who moves it (verb "backup").
        url: Address of the new data base.

    Raises:
        Refused: The actor may not, or the new data base cannot be used, is not empty, or differs.
    """
    require(actor, "backup")
    audit.note(actor, "move catalogue")
    return catalogue.move_to(url)
