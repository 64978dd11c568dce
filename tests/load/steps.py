"""Figures that were measured with one number of sessions."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

HZ = 5.0
"""Scans per second of a session, as a lidar of a TurtleBot sends."""
LATE_MS = 200.0
"""Time in which the next scan is due: a service whose p99 is longer is late."""
_KEPT_UP = 0.95


@dataclass(frozen=True)
class Step:
    """Figures of one number of sessions.

    Attributes:
        sessions: that sent scans at the same time.
        seconds: that were measured.
        scans: answered 200.
        p50_ms, p99_ms, most_ms: from the sending of a scan to its response.
        refused: number of refusals by status, such as {"503": 4}; "none" are scans without a response, which happens
            where a connection that was idle for 5 s is closed as a scan is sent. Each is sent again under its key.
        impolite: refusals without `Retry-After`, or that are no problem document.
        cpu_s: CPU time by part: "service", "database", "balancer", "robots".
        causes: details of the problem documents of the refusals, one of each kind.
    """

    sessions: int
    seconds: float
    scans: int
    p50_ms: float
    p99_ms: float
    most_ms: float
    refused: Mapping[str, int]
    impolite: int
    cpu_s: Mapping[str, float]
    causes: Mapping[str, str]

    @property
    def scans_per_s(self) -> float:
        """Scans answered per second."""
        return self.scans / self.seconds

    @property
    def cpu_ms_per_scan(self) -> float:
        """CPU time of the service per scan, milliseconds."""
        return 1e3 * self.cpu_s["service"] / max(1, self.scans)

    @property
    def cores(self) -> dict[str, float]:
        """Cores in use, by part."""
        return {part: seconds / self.seconds for part, seconds in self.cpu_s.items()}

    @property
    def reason(self) -> str | None:
        """Reason why a service does not carry so many sessions; None: it does."""
        if self.refused:
            return "refuses"
        if self.p99_ms > LATE_MS:
            return "late"
        if self.scans_per_s < _KEPT_UP * HZ * self.sessions:
            return "behind"
        return None


def step_of(
    sessions: int,
    seconds: float,
    times_ms: Sequence[float],
    refused: Counter[str],
    impolite: int,
    cpu_s: Mapping[str, float],
    causes: Mapping[str, str],
) -> Step:
    """Summarise what robots measured; `times_ms` are those of the scans answered 200."""
    ordered = sorted(times_ms) or [0.0]

    def at(share: float) -> float:
        return round(ordered[min(len(ordered) - 1, int(share * len(ordered)))], 2)

    rounded = {part: round(value, 3) for part, value in cpu_s.items()}
    return Step(
        sessions,
        round(seconds, 3),
        len(times_ms),
        at(0.5),
        at(0.99),
        at(1.0),
        dict(refused),
        impolite,
        rounded,
        dict(causes),
    )
