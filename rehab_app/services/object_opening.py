"""The object store that the settings name."""

from __future__ import annotations

from rehab_app.config import StoreSettings, secret_key
from sessions.store.object_store import ObjectPlace, ObjectStore


def open_store(settings: StoreSettings) -> ObjectStore:
    """A client of the store; nothing is asked of it yet.

    Args:
        settings: Section ``[store]``, with a bucket.

    Raises:
        Refused: The client is not installed, or the settings make no sense to it.
    """
    return ObjectStore(
        ObjectPlace(
            bucket=settings.bucket,
            prefix=settings.prefix,
            endpoint=settings.endpoint,
            region=settings.region,
            access_key=settings.access_key,
            secret_key=secret_key(settings),
            timeout_s=settings.timeout_s,
        )
    )
