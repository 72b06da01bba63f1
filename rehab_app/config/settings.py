"""What a person may set of an installation: every key with its type, bounds, default and meaning.

The dataclasses below are the only list of keys: the file, the environment, ``rehab-app config`` and the table
of ``docs/operation.md`` follow them.
"""

from __future__ import annotations

import socket
from dataclasses import dataclass, field
from typing import Annotated, Literal, TypeAlias

from msgspec import Meta

SECRET = {"secret": True}
"""Marks a field whose value is never shown, logged or put into a message."""

Level: TypeAlias = Literal["debug", "info", "warning", "error"]
Format: TypeAlias = Literal["json", "text"]


@dataclass(frozen=True, slots=True)
class StoreSettings:
    """An S3-compatible object store that takes sealed recordings; without a bucket there is none."""

    bucket: Annotated[str, Meta(max_length=63, description="bucket; empty: recordings stay here only")] = ""
    prefix: Annotated[str, Meta(max_length=200, description="what every object's name begins with")] = ""
    endpoint: Annotated[str, Meta(description="address of the service; empty: that of the region")] = ""
    region: Annotated[str, Meta(max_length=64, description="region that requests are signed for")] = (
        "us-east-1"
    )
    access_key: Annotated[str, Meta(description="name of the access key")] = ""
    secret_key: Annotated[
        str, Meta(description="its secret; better in `secret_key_file` or the environment")
    ] = field(default="", metadata=SECRET, repr=False)
    secret_key_file: Annotated[str, Meta(description="file that holds the secret in its first line")] = ""
    timeout_s: Annotated[float, Meta(gt=0, le=600, description="longest wait for one answer, s")] = 30.0


@dataclass(frozen=True, slots=True)
class RecomputeSettings:
    """Re-analysis of what was recorded."""

    scheduler: Annotated[str, Meta(description="address of a Dask scheduler; empty: processes here")] = ""
    workers: Annotated[int, Meta(ge=0, le=256, description="processes here; 0: one for each core")] = 0


@dataclass(frozen=True, slots=True)
class ServerSettings:
    """What browsers reach."""

    host: Annotated[str, Meta(min_length=1, description="address to listen on")] = "127.0.0.1"
    port: Annotated[int, Meta(ge=1, le=65535, description="port to listen on")] = 8080
    tls_cert: Annotated[str, Meta(description="certificate chain, PEM; empty: plain HTTP")] = ""
    tls_key: Annotated[str, Meta(description="its private key, PEM")] = ""


@dataclass(frozen=True, slots=True)
class LogSettings:
    """What the server writes of its own doing; never who a patient is."""

    level: Annotated[Level, Meta(description="least severity that is written")] = "warning"
    format: Annotated[Format, Meta(description="one JSON object a line, or text for a person")] = "json"
    file: Annotated[str, Meta(description="file to append to; empty: standard error")] = ""


@dataclass(frozen=True, slots=True)
class MetricsSettings:
    """The page /metrics."""

    token: Annotated[
        str, Meta(description="bearer token that lets other machines ask; empty: this machine only")
    ] = field(default="", metadata=SECRET, repr=False)


@dataclass(frozen=True, slots=True)
class HealthSettings:
    """When /healthz says that this server should get no work."""

    free_disk_bytes: Annotated[
        int, Meta(ge=0, description="least free space of the clinic folder, bytes")
    ] = 1_000_000_000
    heartbeat_s: Annotated[
        float, Meta(ge=0.2, le=60, description="longest silence of a movement's picture while it runs, s")
    ] = 2.0


@dataclass(frozen=True, slots=True)
class Settings:
    """All settings of an installation.

    Attributes:
        catalogue_url: Where the catalogue lies.
        station: Name of this machine among the clinic's.
        store: Object store.
        recompute: Re-analysis.
        server: What browsers reach.
        log: What the server writes.
        metrics: The page /metrics.
        health: The page /healthz.
    """

    catalogue_url: Annotated[
        str, Meta(description="URL of the catalogue, such as `postgresql://...`; empty: a file in the folder")
    ] = field(default="", metadata=SECRET, repr=False)
    station: Annotated[
        str,
        Meta(pattern=r"^[A-Za-z0-9._-]{0,63}$", description="name of this machine; empty: its host name"),
    ] = ""
    store: StoreSettings = field(default_factory=StoreSettings)
    recompute: RecomputeSettings = field(default_factory=RecomputeSettings)
    server: ServerSettings = field(default_factory=ServerSettings)
    log: LogSettings = field(default_factory=LogSettings)
    metrics: MetricsSettings = field(default_factory=MetricsSettings)
    health: HealthSettings = field(default_factory=HealthSettings)

    @property
    def station_name(self) -> str:
        """The station, by its host name where none was chosen."""
        return self.station or socket.gethostname()
