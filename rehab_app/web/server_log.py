"""What the server writes of its own doing: one event a line, never who a patient is.

Our events carry an event name and figures. Of other libraries only the fixed text of a message is written,
without what they fill in, and of an exception its kind and place, without its message: either could quote a
name, a note or a statement with its values.
"""

from __future__ import annotations

import contextlib
import logging
import queue
import secrets
import sys
import threading
import traceback
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from logging.handlers import WatchedFileHandler
from pathlib import Path
from types import TracebackType
from typing import Any, TypeAlias

import msgspec

from rehab_app.config import LogSettings
from rehab_app.errors import Refused

Figure: TypeAlias = str | int | float | bool
request_id: ContextVar[str] = ContextVar("request_id", default="")
"""Id of the request that is being answered, "" outside one."""
_OWN = logging.getLogger("rehab_app.server")
_FIGURES = "figures"
_FRAMES = 12
_MOST_WAITING = 10_000
_PATIENCE_S = 2.0


def tell(event: str, level: int = logging.INFO, **figures: Figure) -> None:
    """Write an event.

    Args:
        event: Its name, fixed words.
        level: Severity as of ``logging``.
        figures: What belongs to it: numbers, pseudonyms, fixed words; SI units in the names.
    """
    _OWN.log(level, event, extra={_FIGURES: figures})


def new_request_id() -> str:
    """An id for one request."""
    return secrets.token_hex(6)


@contextmanager
def logging_to(settings: LogSettings, station: str) -> Generator[None]:
    """Write the log of this process as a person set it, until the end of the block.

    Args:
        settings: Level, format and file.
        station: Name of this machine, part of every line.

    Raises:
        Refused: The file cannot be written.
    """
    handler = _Behind(_target(settings.file), EventLines(station, as_json=settings.format == "json"))
    root = logging.getLogger()
    before, levels = root.handlers[:], (root.level, _OWN.level)
    root.handlers = [handler]
    root.setLevel(max(logging.WARNING, _level(settings)))
    _OWN.setLevel(_level(settings))
    try:
        yield
    finally:
        root.handlers = before
        root.setLevel(levels[0])
        _OWN.setLevel(levels[1])
        handler.close()


class EventLines(logging.Formatter):
    """One line for each record.

    Args:
        station: Name of this machine.
        as_json: One JSON object, else text for a person.
    """

    def __init__(self, station: str, *, as_json: bool) -> None:
        super().__init__()
        self._station = station
        self._as_json = as_json

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        line = self._content(record)
        if self._as_json:
            return msgspec.json.encode(line).decode()
        rest = " ".join(f"{key}={value}" for key, value in line.items() if key not in _HEAD)
        return f"{line['utc']} {line['level']} {line['event']} {rest}".rstrip()

    def _content(self, record: logging.LogRecord) -> dict[str, Figure]:
        figures: Mapping[str, Figure] = getattr(record, _FIGURES, {})
        line: dict[str, Figure] = {
            "utc": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "event": _event(record),
            "station": self._station,
        }
        if request_id.get():
            line["request"] = request_id.get()
        line |= figures
        if record.exc_info and record.exc_info[0] is not None:
            line["error"] = record.exc_info[0].__name__
            line["trace"] = _places(record.exc_info[2])
        return line


_HEAD = frozenset(("utc", "level", "event", "station"))


def _event(record: logging.LogRecord) -> str:
    if record.name == _OWN.name:
        return str(record.msg)
    return f"{record.name}: {' '.join(str(record.msg).split())[:120]}" if record.args else record.name


def _places(trace: TracebackType | None) -> str:
    """Where it happened: file, line and function, the innermost last; no values."""
    frames = traceback.extract_tb(trace)[-_FRAMES:]
    places = " > ".join(f"{Path(one.filename).name}:{one.lineno} {one.name}" for one in frames)
    return f"Traceback: {places}"


def _level(settings: LogSettings) -> int:
    return logging.getLevelNamesMapping()[settings.level.upper()]


def _target(file: str) -> logging.Handler:
    if not file:
        return _Quiet(sys.stderr)
    path = Path(file).expanduser().absolute()
    try:
        return _QuietFile(path, encoding="utf-8")  # goes on in a new file after a rotation
    except OSError as error:
        why = f"{path} ({error.strerror or error})"
        raise Refused("setting log.file", why, "a file that can be written", "name another") from error


class _Behind(logging.Handler):
    """Formats at once and writes behind: whoever logs, above all the stop, never waits for a pipe or a disk.

    Args:
        target: What writes.
        lines: How a record becomes a line.
    """

    def __init__(self, target: logging.Handler, lines: logging.Formatter) -> None:
        super().__init__()
        self.setFormatter(lines)
        self._target = target
        self._waiting: queue.Queue[logging.LogRecord | None] = queue.Queue(_MOST_WAITING)
        self._thread = threading.Thread(target=self._write, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:
        line = logging.makeLogRecord({"msg": self.format(record), "levelno": record.levelno})
        with contextlib.suppress(queue.Full):  # what cannot be written in time is lost, the server goes on
            self._waiting.put_nowait(line)

    def close(self) -> None:
        with contextlib.suppress(queue.Full):
            self._waiting.put(None, timeout=_PATIENCE_S)
        self._thread.join(_PATIENCE_S)
        if not self._thread.is_alive():  # one that hangs in a write holds the target
            with contextlib.suppress(OSError):
                self._target.close()
        super().close()

    def _write(self) -> None:
        while (line := self._waiting.get()) is not None:
            self._target.handle(line)


class _Quiet(logging.StreamHandler[Any]):
    """Writes to a stream; where that fails the server goes on."""

    def handleError(self, record: logging.LogRecord) -> None:
        del record


class _QuietFile(WatchedFileHandler):
    """Writes to a file; where that fails (a full disk) the server goes on."""

    def handleError(self, record: logging.LogRecord) -> None:
        del record
