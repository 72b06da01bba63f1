"""Session files: MCAP on disk, typed records and columns in memory."""

from sessions.store.columns import Columns
from sessions.store.diskfile import PARTIAL_SUFFIX
from sessions.store.integrity import SessionInfo, TopicInfo, Verification, info, verify
from sessions.store.overview import Overview, Series
from sessions.store.reader import SessionReader
from sessions.store.recover import Recovery, partials, recover
from sessions.store.writer import SealedSession, SessionWriter

__all__ = [
    "PARTIAL_SUFFIX",
    "Columns",
    "Overview",
    "Recovery",
    "SealedSession",
    "Series",
    "SessionInfo",
    "SessionReader",
    "SessionWriter",
    "TopicInfo",
    "Verification",
    "info",
    "partials",
    "recover",
    "verify",
]
