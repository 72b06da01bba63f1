"""The attachment ``overview``: enough of a session for a first look, without reading the file.

It is gathered while writing. Every series keeps at most ten rows a second, and halves its rate whenever it
grows beyond ``ROWS_MAX`` rows, so that an hour costs no more than ten minutes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import nan
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from sessions.records import Event, columns_of
from sessions.records.fields import Float64, Int64
from sessions.records.topics import EVENTS, HAND_POSE, PATIENT_POSE, PHASE, REFERENCE
from sessions.store.damage import Damaged

ATTACHMENT_NAME = "overview"
MEDIA_TYPE = "application/json"
INTERVAL_NS = 100_000_000
ROWS_MAX = 4096
_DECIMALS = 5  # 1e-5 rad and 1e-5 m are far below what a picture shows
SERIES: dict[str, tuple[str, ...]] = {
    HAND_POSE.name: ("joints_rad", "fingertips_palm_m"),
    REFERENCE.name: ("path_s", "joints_rad", "fingertips_palm_m"),
    PATIENT_POSE.name: ("joints_rad", "fingertips_palm_m"),
    PHASE.name: ("repetition", "path_s", "path_speed", "assistance"),
}


@dataclass(frozen=True, slots=True)
class Series:
    """One topic at 10 Hz or less.

    Attributes:
        t_ns: Times (N,), monotonic.
        columns: Arrays (N, ...) by field name, in the units of the record type.
    """

    t_ns: Int64
    columns: Mapping[str, Float64]


@dataclass(frozen=True, slots=True)
class Overview:
    """A session at a glance.

    Attributes:
        series: Thinned columns by topic.
        events: All events, in the order written.
        metrics: JSON of what the writer's caller summed up, empty where nothing was.
    """

    series: Mapping[str, Series]
    events: tuple[Event, ...]
    metrics: bytes


@dataclass(slots=True)
class _Thinned:
    """Rows of one topic, gathered at a rate that falls as they grow."""

    names: tuple[str, ...]
    interval_ns: int = INTERVAL_NS
    t_ns: list[int] = field(default_factory=list[int])
    rows: list[tuple[NDArray[Any], ...]] = field(default_factory=list[tuple[NDArray[Any], ...]])

    def add(self, t_ns: int, record: Any) -> None:
        if self.t_ns and t_ns // self.interval_ns == self.t_ns[-1] // self.interval_ns:
            return  # one row per tenth of a second, however unevenly they come
        self.t_ns.append(t_ns)
        values = (np.asarray(getattr(record, name), dtype=np.float64) for name in self.names)
        self.rows.append(tuple(np.round(value, _DECIMALS) for value in values))
        if len(self.t_ns) > ROWS_MAX:
            self.interval_ns *= 2
            del self.t_ns[1::2], self.rows[1::2]


class _SeriesFile(msgspec.Struct):
    t_ns: list[int]
    columns: dict[str, list[list[float | None]]]


class _OverviewFile(msgspec.Struct):
    interval_ns: int
    series: dict[str, _SeriesFile]
    events: list[dict[str, str | int | float | None]]
    metrics: msgspec.Raw = msgspec.Raw(b"null")


class OverviewBuilder:
    """Sees every record that is written and keeps what a first look needs."""

    def __init__(self) -> None:
        self._series = {topic: _Thinned(names) for topic, names in SERIES.items()}
        self._events: list[Event] = []
        self.metrics = b"null"

    def see(self, topic: str, t_ns: int, record: Any) -> None:
        """Take note of one record."""
        thinned = self._series.get(topic)
        if thinned is not None:
            thinned.add(t_ns, record)
        elif topic == EVENTS.name:
            self._events.append(record)

    def encode(self) -> bytes:
        """The attachment's JSON; NaN is null there, arrays are rows of numbers laid flat."""
        series = {
            topic: _SeriesFile(
                thinned.t_ns,
                {
                    name: [row[index].ravel().tolist() for row in thinned.rows]
                    for index, name in enumerate(thinned.names)
                },
            )
            for topic, thinned in self._series.items()
            if thinned.t_ns
        }
        events = [msgspec.to_builtins(event) for event in self._events]
        file = _OverviewFile(INTERVAL_NS, series, events, msgspec.Raw(self.metrics))
        return msgspec.json.encode(file)


def decode_overview(data: bytes) -> Overview:
    """The overview of an attachment.

    Raises:
        Damaged: It is not the JSON that ``OverviewBuilder`` writes.
    """
    try:
        file = msgspec.json.decode(data, type=_OverviewFile)
        series = {topic: _series(topic, found) for topic, found in file.series.items() if topic in SERIES}
        events = tuple(_event(found) for found in file.events)
    except (msgspec.MsgspecError, RecursionError, ValueError, TypeError) as error:
        raise Damaged("its overview cannot be read") from error
    metrics = bytes(file.metrics)
    return Overview(series, events, b"" if metrics == b"null" else metrics)


def _series(topic: str, found: _SeriesFile) -> Series:
    count = len(found.t_ns)
    columns: dict[str, Float64] = {}
    for name in SERIES[topic]:
        shape = columns_of(_record_of(topic))[name].shape
        columns[name] = np.array(found.columns.get(name, []), dtype=np.float64).reshape(count, *shape)
    return Series(np.array(found.t_ns, dtype=np.int64), columns)


def _event(found: dict[str, str | int | float | None]) -> Event:
    """An event from its JSON, where NaN is null."""
    return msgspec.convert({name: nan if value is None else value for name, value in found.items()}, Event)


def _record_of(topic: str) -> type[Any]:
    return next(item.record for item in (HAND_POSE, REFERENCE, PATIENT_POSE, PHASE) if item.name == topic)
