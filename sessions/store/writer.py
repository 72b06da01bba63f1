"""Writing a session: append, flush twice a second, seal by an atomic rename."""

from __future__ import annotations

import threading
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any, cast

import msgspec
from mcap.writer import CompressionType, Writer

from sessions.errors import Refused
from sessions.records import SessionHeader, Topic
from sessions.store import refusals
from sessions.store.codec import Codec, codec_for
from sessions.store.diskfile import HashedFile, check_target, partial_path, publish
from sessions.store.header import METADATA_NAME, header_to_texts
from sessions.store.overview import ATTACHMENT_NAME, MEDIA_TYPE, OverviewBuilder
from sessions.store.recordtimes import times_of
from sessions.store.sideflush import SideFlush
from sessions.timebase import Timebase

PROFILE = "rehab-app"
CHUNK_BYTES = 256 * 1024
FLUSH_NS = 500_000_000
_UTC_MAX_NS = 2**63 - 1


@dataclass(frozen=True, slots=True)
class SealedSession:
    """A finished session file.

    Attributes:
        path: Where it lies.
        sha256: Its digest in hexadecimal, which also stands in the file ``<path>.sha256``.
        bytes: Its length.
    """

    path: Path
    sha256: str
    bytes: int


@dataclass(slots=True)
class _Stream:
    channel_id: int
    codec: Codec
    sequence: int = 0


class SessionWriter:
    """Writes one session file; a context manager.

    The file grows as ``<stem>.partial.mcap`` and takes its final name only in ``seal``. Leaving the context
    without sealing, by an exception or not, leaves the partial file, which ``recover`` can read. Whatever was
    written more than half a second ago, in time of the clock or of the messages, has reached the system; what
    was written more than a second ago by the clock has reached the disk, so a power cut loses no more.

    Args:
        path: Final name, ending in ``.mcap``; must not exist.
        header: Who, what, when; it also fixes how monotonic times become UTC.
        partial: Where the file grows, instead of beside its final name.

    Raises:
        Refused: The path cannot be written to.
    """

    def __init__(self, path: Path, header: SessionHeader, *, partial: Path | None = None) -> None:
        check_target(path)
        self.path = path
        self.partial = partial_path(path) if partial is None else partial
        self.header = header
        self._timebase = Timebase(header.utc_start_ns, header.monotonic_start_ns)
        self._streams: dict[str, _Stream] = {}
        self._overview = OverviewBuilder()
        self._lock = threading.Lock()
        self._closed = False
        self._failure: OSError | None = None
        self._pending = False
        self._settled = True
        self._flushed_ns = header.utc_start_ns
        self._start()

    def __enter__(self) -> SessionWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def write(self, topic: Topic, record: Any) -> None:
        """Append one record; its own ``t_ns`` says when. Blocks are filed under their last tick.

        Raises:
            Refused: The record does not fit its topic, is an image without consent, its time does not fit the
                clock, or the disk is full.
        """
        if topic.needs_consent and not self.header.consent_images:
            raise refusals.without_consent(topic.name)
        first_ns, last_ns = times_of(topic, record)
        utc_ns = self._utc(last_ns)
        with self._lock:
            self._check_open()
            stream = self._streams.get(topic.name) or self._open_stream(topic)
            data = stream.codec.encode(record, utc_ns)
            stream.sequence += 1
            try:
                self._writer.add_message(
                    stream.channel_id, utc_ns, data, self._utc(first_ns), stream.sequence & 0xFFFFFFFF
                )
                self._overview.see(topic.name, last_ns, record)
                self._pending, self._settled = True, False
                if abs(utc_ns - self._flushed_ns) >= FLUSH_NS:
                    self._flushed_ns = utc_ns
                    self._flush()
            except OSError as error:
                raise self._fail(error) from error

    def attach_metadata(self, name: str, texts: dict[str, str]) -> None:
        """Add a metadata record of one's own, such as how the file was recovered."""
        with self._lock:
            self._check_open()
            self._writer.add_metadata(name, texts)

    def attach_overview(self, metrics: Any) -> None:
        """Put figures into the overview, which is written when the session is sealed.

        Args:
            metrics: A frozen dataclass that JSON can hold, or finished JSON as bytes.

        Raises:
            Refused: The bytes are no JSON.
        """
        data = metrics
        if is_dataclass(metrics):
            data = msgspec.json.encode(metrics)
        try:
            msgspec.json.decode(data)
        except (msgspec.MsgspecError, TypeError) as error:
            raise Refused("overview", "no JSON", "JSON or a dataclass", "encode it first") from error
        with self._lock:
            self._overview.metrics = bytes(data)

    def flush(self) -> None:
        """Hand everything written so far to the operating system.

        Raises:
            Refused: The disk is full.
        """
        with self._lock:
            self._check_open()
            try:
                self._flush()
            except OSError as error:
                raise self._fail(error) from error

    def seal(self) -> SealedSession:
        """Write overview and index, wait for the disk, and give the file its final name.

        Raises:
            Refused: The disk is full, or the final name was taken meanwhile; the partial file stays.
        """
        with self._lock:
            self._check_open()
            try:
                start = self.header.utc_start_ns
                self._writer.add_attachment(
                    start, start, ATTACHMENT_NAME, MEDIA_TYPE, self._overview.encode()
                )
                self._writer.finish()
                self._file.sync()
                sealed = SealedSession(self.path, self._file.sha256(), self._file.tell())
                self._shut()
                publish(self.partial, self.path, sealed.sha256)
            except OSError as error:
                raise self._fail(error) from error
        self._side.stop()
        return sealed

    def close(self) -> None:
        """Flush and let go without sealing; does nothing after ``seal``."""
        with self._lock:
            if not self._closed:
                try:
                    if self._failure is None:
                        self._flush()
                    self._shut()
                except OSError as error:
                    raise self._fail(error) from error
        self._side.stop()

    def _start(self) -> None:
        try:
            self._file = HashedFile(self.partial)
        except FileExistsError as error:
            raise Refused(
                "partial session",
                f"{self.partial.name!r}, which exists",
                "absent",
                "rehab-app recover it, or remove it if another recording is not writing it now",
            ) from error
        except OSError as error:
            raise refusals.unwritable(self.partial, error) from error
        self._writer = Writer(
            cast(IO[Any], self._file),
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_data_crcs=True,
        )
        try:
            self._writer.start(PROFILE, f"rehab-app {self.header.software_version}")
            self._writer.add_metadata(METADATA_NAME, header_to_texts(self.header))
            self._file.flush()
        except OSError as error:
            raise self._fail(error) from error
        except UnicodeEncodeError as error:
            self._file.close()
            self.partial.unlink()
            raise Refused("header", "not text", "text that UTF-8 can hold", "correct it") from error
        self._side = SideFlush(FLUSH_NS / 1e9, self._flush_aside)

    def _flush_aside(self) -> None:
        try:
            with self._lock:
                if self._settled or self._closed or self._failure is not None:
                    return
                if self._pending:
                    self._flush()
                self._settled = True
            self._file.settle()  # without the lock: the recorder never waits for the disk
        except OSError as error:
            self._failure = error  # the next call of the recorder says so

    def _flush(self) -> None:
        self._writer.flush()
        self._pending = False

    def _open_stream(self, topic: Topic) -> _Stream:
        codec = codec_for(topic)
        schema_id = self._writer.register_schema(topic.schema, "protobuf", codec.schema)
        channel_id = self._writer.register_channel(
            topic.name, "protobuf", schema_id, {"version": str(topic.version)}
        )
        return self._streams.setdefault(topic.name, _Stream(channel_id, codec))

    def _utc(self, t_ns: int) -> int:
        utc_ns = self._timebase.to_utc_ns(t_ns)
        if not 0 <= utc_ns <= _UTC_MAX_NS:
            raise Refused(
                "record time", f"{t_ns} ns", "within the epoch of UTC", "stamp it by the session's clock"
            )
        return utc_ns

    def _check_open(self) -> None:
        if self._failure is not None:
            raise refusals.unwritable(self.partial, self._failure)
        if self._closed:
            raise Refused("session", "sealed or closed", "open", "start a new session to record more")

    def _shut(self) -> None:
        self._closed = True
        self._file.close()

    def _fail(self, error: OSError) -> Refused:
        """Close what can be closed, keep the partial file, and say so."""
        self._failure = error
        self._closed = True
        try:
            self._file.close()
        except OSError:
            pass  # the same full disk; what reached it stays recoverable
        return refusals.unwritable(self.partial, error)
