"""What an operator watches, in Prometheus' text form. Labels are route templates and kinds, never ids."""

from collections.abc import Callable

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

_SECONDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0)


class Metrics:
    """The service's counters, in a registry of their own."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self._requests = Counter(
            "voa_http_requests", "Requests answered.", ["method", "route", "status"], registry=self._registry
        )
        self._seconds = Histogram(
            "voa_http_request_seconds", "Wall time of a request.", ["route"], buckets=_SECONDS, registry=self._registry
        )
        self._observations = Counter(
            "voa_observations",
            "Scans and grasp outcomes, by what became of them.",
            ["kind", "result"],
            registry=self._registry,
        )

        self._rpc = Counter("voa_rpc_requests", "Calls by Zenoh.", ["method", "status"], registry=self._registry)
        self._rpc_seconds = Histogram(
            "voa_rpc_request_seconds", "Wall time of a call.", ["method"], buckets=_SECONDS, registry=self._registry
        )
        self._zenoh = Counter(
            "voa_zenoh_samples",
            "Scans heard, and what became of them; beliefs published, or not heard by anybody; links lost.",
            ["event"],
            registry=self._registry,
        )
        self._connections = Counter(
            "voa_http_connections_refused",
            "Connections and requests refused or ended.",
            ["reason"],
            registry=self._registry,
        )

    def connection(self, reason: str) -> None:
        """Count a connection that was refused or ended."""
        self._connections.labels(reason).inc()

    def rpc(self, method: str, status: int, seconds: float) -> None:
        """One call was answered."""
        self._rpc.labels(method, str(status)).inc()
        self._rpc_seconds.labels(method).observe(seconds)

    def zenoh(self, event: str) -> None:
        """One thing happened on Zenoh that nobody gets an answer to."""
        self._zenoh.labels(event).inc()

    def request(self, method: str, route: str, status: int, seconds: float) -> None:
        """One request was answered."""
        self._requests.labels(method, route, str(status)).inc()
        self._seconds.labels(route).observe(seconds)

    def observation(self, kind: str, result: str) -> None:
        """One scan or outcome was accepted, or was not for a reason."""
        self._observations.labels(kind, result).inc()

    def gauge(self, name: str, help_: str, read: Callable[[], float]) -> None:
        """A figure that is read when somebody asks."""
        Gauge(name, help_, registry=self._registry).set_function(read)

    def text(self) -> bytes:
        """Everything, as Prometheus reads it."""
        return generate_latest(self._registry)
