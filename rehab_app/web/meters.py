"""What is measured of the running server, for Prometheus; labels are routes and fixed words, no person."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from rehab_app.services.clinic import Clinic
from rehab_app.services.tally import CountedAudit

_ANSWER_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
_STOP_S = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5)


class Meters:
    """All figures of one server, in a registry of its own.

    Args:
        clinic: The clinic that is read when somebody asks.

    Attributes:
        websockets: Open websockets.
    """

    def __init__(self, clinic: Clinic) -> None:
        self._registry = CollectorRegistry()
        words = ("method", "route", "status")
        self._requests = Counter("rehab_requests", "Requests answered.", words, registry=self._registry)
        self._answers = Histogram(
            "rehab_request_seconds",
            "Time until an answer was complete.",
            ("route",),
            buckets=_ANSWER_S,
            registry=self._registry,
        )
        self._stop = Histogram(
            "rehab_stop_seconds",
            "Time from the arrival of a stop until it was answered; the stop word is written before.",
            buckets=_STOP_S,
            registry=self._registry,
        )
        self.websockets = Gauge("rehab_websockets", "Open websockets.", registry=self._registry)
        self._registry.register(_OfClinic(clinic))

    def answered(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count one request.

        Args:
            method: Its method.
            route: Template of its path, such as ``/patients/{patient}``.
            status: Status of the answer.
            seconds: Time until the answer was complete.
        """
        self._requests.labels(method, route, str(status)).inc()
        self._answers.labels(route).observe(seconds)

    def stopped(self, seconds: float) -> None:
        """Count one press of the stop."""
        self._stop.observe(seconds)

    def watch(self, name: str, meaning: str, read: Callable[[], float]) -> None:
        """Add a figure that is read whenever somebody asks, such as the length of a queue.

        Args:
            name: Such as ``rehab_uploads_waiting``.
            meaning: What it is.
            read: Gives it; must be quick.
        """
        Gauge(name, meaning, registry=self._registry).set_function(read)

    def text(self) -> bytes:
        """Everything in Prometheus' text format."""
        return generate_latest(self._registry)


class _OfClinic(Collector):
    """What is read of the clinic at the moment somebody asks; it asks no data base."""

    def __init__(self, clinic: Clinic) -> None:
        self._clinic = clinic

    def collect(self) -> Iterator[CounterMetricFamily | GaugeMetricFamily]:
        yield from self._counts()
        shown = self._clinic.live.snapshot()
        late = "How late the control loop's ticks began in the last movement, 99th percentile."
        yield GaugeMetricFamily("rehab_motion_late_seconds", late, shown.late_p99_ns / 1e9)
        missed = "Ticks of the last movement that missed their deadline."
        yield GaugeMetricFamily("rehab_motion_overruns", missed, float(shown.overruns))
        playing = "Whether a movement is played."
        yield GaugeMetricFamily("rehab_motion_playing", playing, float(shown.state == "playing"))
        latched = "Whether the stop is latched."
        yield GaugeMetricFamily("rehab_stop_latched", latched, float(bool(shown.stop_source)))
        waiting, away = "Rows that wait for the catalogue.", "Whether the catalogue did not answer just now."
        outbox = self._clinic.outbox.state()
        yield GaugeMetricFamily("rehab_outbox_waiting", waiting, float(outbox.waiting))
        yield GaugeMetricFamily("rehab_catalogue_away", away, float(outbox.away))
        free = "Free space of the clinic folder."
        yield GaugeMetricFamily("rehab_disk_free_bytes", free, shutil.disk_usage(self._clinic.folder).free)

    def _counts(self) -> Iterator[CounterMetricFamily]:
        audit = self._clinic.audit
        if not isinstance(audit, CountedAudit):
            return
        acts = CounterMetricFamily(
            "rehab_acts",
            "What was done, by the verb of the audit: session, record, play ...",
            labels=["verb"],
        )
        for verb, count in audit.verbs().items():
            acts.add_metric([verb], count)
        yield acts
        stops = CounterMetricFamily("rehab_stops", "Stops by cause.", labels=["cause"])
        for cause, count in audit.stops().items():
            stops.add_metric([cause], count)
        yield stops
