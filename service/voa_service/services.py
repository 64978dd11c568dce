"""Services: the use cases and work queues that every entrypoint is built with."""

from dataclasses import dataclass

from voa_service.access.gate import Gate
from voa_service.requests.bodies import Reader
from voa_service.runtime.changes import Changes
from voa_service.runtime.feeds import Feeds
from voa_service.runtime.metrics import Metrics
from voa_service.runtime.queues import WorkQueue
from voa_service.settings import Limits
from voa_service.usecases.acting import ActingRobots
from voa_service.usecases.claims import Claims
from voa_service.usecases.health import HealthCheck
from voa_service.usecases.looks import AnnouncedLooks
from voa_service.usecases.objects import Objects
from voa_service.usecases.rankings import Rankings
from voa_service.usecases.robots import Robots
from voa_service.usecases.scenarios import Scenarios
from voa_service.usecases.sessions import Sessions
from voa_service.usecases.updates import Updates


@dataclass(frozen=True)
class Services:
    """The use cases and the queues in which their work is done, built by `bootstrap`.

    Attributes:
        objects: use cases about meshes.
        scenarios: use cases about scenarios.
        sessions: use cases about whole sessions.
        updates: use cases that change a session's belief.
        looks: use cases that announce looks.
        rankings: use cases that rank looks and grasps.
        robots: reports on robots.
        claims: use cases about claims of robots.
        acting: use cases about the part that robots take in sessions.
        health: use case that reports the health of this process.
        changes: notifies followers of committed changes.
        metrics: counters and gauges.
        limits: of requests and responses.
        reads: queue of calls that read, or compute quickly, and write nothing.
        writes: queue of calls that may wait for a lock of the database, above all scans; separate, so that no read
            waits for one.
        probes: queue of readiness checks.
        feeds: followers of sessions, whose reads have a queue of their own.
        reader: reads messages from bytes.
        gate: identifies callers by their keys, and admits calls.
        names: host names under which the service may be called, besides those of the loopback; None: any name.
        heavy: queue of rankings, predictions and new scenarios.
        meshes: queue of mesh files, as many at a time as the memory allows.
        rests: queue of stable poses of objects; separate, so that no ranking waits for one.
    """

    objects: Objects
    scenarios: Scenarios
    sessions: Sessions
    updates: Updates
    looks: AnnouncedLooks
    rankings: Rankings
    robots: Robots
    claims: Claims
    acting: ActingRobots
    health: HealthCheck
    changes: Changes
    metrics: Metrics
    limits: Limits
    reads: WorkQueue
    writes: WorkQueue
    probes: WorkQueue
    feeds: Feeds
    reader: Reader
    gate: Gate
    names: frozenset[str] | None
    heavy: WorkQueue
    meshes: WorkQueue
    rests: WorkQueue
