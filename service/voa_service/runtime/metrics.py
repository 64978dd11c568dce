"""Metrics for operators, in the text form of Prometheus. Labels are routes, kinds and mapped robots, never ids."""

from collections.abc import Callable, Iterator, Mapping

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.registry import Collector

_SECONDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0)


_BANDS = 5
"""Number of equal bands of expected scores in which reported outcomes are counted."""


class _Ages(Collector):
    """Collector of the age of each mapped robot's newest scan; a robot without a scan has none."""

    def __init__(self, ages: Callable[[], Mapping[str, float]]) -> None:
        self._ages = ages

    def collect(self) -> Iterator[GaugeMetricFamily]:
        """Yield the gauge, with a value for each robot."""
        family = GaugeMetricFamily(
            "voa_robot_scan_age_seconds", "Age of the newest scan of a mapped robot, in seconds.", labels=["robot"]
        )
        for robot, age in self._ages().items():
            family.add_metric([robot], age)
        yield family


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
        self._routes: dict[tuple[str, str, int], tuple[Counter, Histogram]] = {}
        self._observations = Counter(
            "voa_observations",
            "Scans and grasp outcomes, by result: accepted, or the reason why not.",
            ["kind", "result"],
            registry=self._registry,
        )
        self._results = {("scan", "accepted"): self._observations.labels("scan", "accepted")}  # the first need not wait

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
        self._methods: dict[tuple[str, int], tuple[Counter, Histogram]] = {}
        self._zenoh = Counter(
            "voa_zenoh_samples",
            "Events on Zenoh: scans received, refused or dropped; beliefs published or dropped; links made and lost.",
            ["event"],
            registry=self._registry,
        )
        self._store_seconds = Histogram(
            "voa_store_seconds",
            "Wall time of a transaction of the database, or of a single statement, in seconds.",
            buckets=_SECONDS,
            registry=self._registry,
        )
        self._attempts = Counter(
            "voa_grasp_attempts",
            "Reported outcomes of grasps, by the expected score that was promised before, and by success.",
            ["promised", "success"],
            registry=self._registry,
        )
        self._promised = Counter(
            "voa_grasp_promised",
            "Sum of the expected scores of the grasps whose outcomes were reported: the promised number of successes.",
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
        counted = self._methods.get((method, status))
        if counted is None:
            counted = self._rpc.labels(method, str(status)), self._rpc_seconds.labels(method)
            self._methods[method, status] = counted
        counted[0].inc()
        counted[1].observe(seconds)

    def zenoh(self, event: str) -> None:
        """Count an event on Zenoh, by its name."""
        self._zenoh.labels(event).inc()

    def request(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count an HTTP request that was answered, with its duration."""
        counted = self._routes.get((method, route, status))
        if counted is None:
            counted = self._requests.labels(method, route, str(status)), self._seconds.labels(route)
            self._routes[method, route, status] = counted
        counted[0].inc()
        counted[1].observe(seconds)

    def observation(self, kind: str, result: str) -> None:
        """Count a scan or grasp outcome, by its result: accepted, or the reason why not."""
        counted = self._results.get((kind, result))
        if counted is None:
            counted = self._results[kind, result] = self._observations.labels(kind, result)
        counted.inc()

    def store(self, seconds: float) -> None:
        """Count a transaction or statement of the database, with its duration."""
        self._store_seconds.observe(seconds)

    def attempt(self, promised: float, *, success: bool) -> None:
        """Count a reported outcome of a grasp.

        Args:
            promised: expected score of the grasp before the outcome, 0 to 1.
            success: True if the grasp succeeded.
        """
        low = min(int(promised * _BANDS), _BANDS - 1) / _BANDS
        self._attempts.labels(f"{low:.1f}-{low + 1 / _BANDS:.1f}", str(success).lower()).inc()
        self._promised.inc(promised)

    def robots(self, ages: Callable[[], Mapping[str, float]]) -> None:
        """Register a gauge of the age of each mapped robot's newest scan, seconds, read whenever they are scraped."""
        self._registry.register(_Ages(ages))

    def gauge(self, name: str, help_: str, read: Callable[[], float]) -> None:
        """Register a gauge whose value is read whenever the metrics are scraped."""
        Gauge(name, help_, registry=self._registry).set_function(read)

    def text(self) -> bytes:
        """Return all metrics in the text form of Prometheus."""
        return generate_latest(self._registry)
