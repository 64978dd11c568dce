"""Metrics for operators, in the text form of Prometheus. Labels are route templates and kinds, never ids."""

from collections.abc import Callable

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

_SECONDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0)


class Metrics:
    """The service's counters, in a registry of their own."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self._requests = Counter(
            "voa_http_requests", "HTTP requests answered.", ["method", "route", "status"], registry=self._registry
        )
        self._seconds = Histogram(
            "voa_http_request_seconds",
            "Wall time of an HTTP request, in seconds.",
            ["route"],
            buckets=_SECONDS,
            registry=self._registry,
        )
        self._observations = Counter(
            "voa_observations",
            "Scans and grasp outcomes, by result: accepted, or the reason why not.",
            ["kind", "result"],
            registry=self._registry,
        )

        self._rpc = Counter(
            "voa_rpc_requests",
            "Remote calls answered, on Zenoh or in this process.",
            ["method", "status"],
            registry=self._registry,
        )
        self._rpc_seconds = Histogram(
            "voa_rpc_request_seconds",
            "Wall time of a remote call, in seconds.",
            ["method"],
            buckets=_SECONDS,
            registry=self._registry,
        )
        self._zenoh = Counter(
            "voa_zenoh_samples",
            "Events on Zenoh: scans received, refused or dropped; beliefs published or dropped; links made and lost.",
            ["event"],
            registry=self._registry,
        )
        self._connections = Counter(
            "voa_http_connections_refused",
            "HTTP connections and requests that were refused or ended, by reason.",
            ["reason"],
            registry=self._registry,
        )

    def connection(self, reason: str) -> None:
        """Count a connection that was refused or ended."""
        self._connections.labels(reason).inc()

    def rpc(self, method: str, status: int, seconds: float) -> None:
        """Count a remote call that was answered, with its duration."""
        self._rpc.labels(method, str(status)).inc()
        self._rpc_seconds.labels(method).observe(seconds)

    def zenoh(self, event: str) -> None:
        """Count an event on Zenoh, by its name."""
        self._zenoh.labels(event).inc()

    def request(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count an HTTP request that was answered, with its duration."""
        self._requests.labels(method, route, str(status)).inc()
        self._seconds.labels(route).observe(seconds)

    def observation(self, kind: str, result: str) -> None:
        """Count a scan or grasp outcome, by its result: accepted, or the reason why not."""
        self._observations.labels(kind, result).inc()

    def gauge(self, name: str, help_: str, read: Callable[[], float]) -> None:
        """Register a gauge whose value is read whenever the metrics are scraped."""
        Gauge(name, help_, registry=self._registry).set_function(read)

    def text(self) -> bytes:
        """Return all metrics in the text form of Prometheus."""
        return generate_latest(self._registry)
