"""Where the norms of a clinic are kept, and how they cease to hold."""

from __future__ import annotations

from sessions.catalogue import Catalogue, Setting

KEY = "population-norms"
_NONE = '{"version":"","norms":[]}'


def withdraw_norms(catalogue: Catalogue, by: str) -> None:
    """Norms that were made with somebody who is erased are cited no more, until they are made anew.

    Args:
        catalogue: Where they are kept.
        by: Who erases.
    """
    kept = catalogue.setting(KEY)
    if kept is not None and kept.content != _NONE:
        catalogue.set(Setting(key=KEY, content=_NONE, by=by))
