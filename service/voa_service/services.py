"""What an entrypoint is given: the use cases, and the queues that they run in."""

from dataclasses import dataclass

from voa_service.requests.bodies import Reader
from voa_service.runtime.changes import Changes
from voa_service.runtime.feeds import Feeds
from voa_service.runtime.metrics import Metrics
from voa_service.runtime.queues import WorkQueue
from voa_service.settings import Limits
from voa_service.usecases.claims import Claims
from voa_service.usecases.health import HealthCheck
from voa_service.usecases.objects import Objects
from voa_service.usecases.rankings import Rankings
from voa_service.usecases.robots import Robots
from voa_service.usecases.scenarios import Scenarios
from voa_service.usecases.sessions import Sessions


@dataclass(frozen=True)
class Services:
    """Built by `bootstrap`, handed to every entrypoint."""

    objects: Objects
    scenarios: Scenarios
    sessions: Sessions
    rankings: Rankings
    robots: Robots
    claims: Claims
    health: HealthCheck
    changes: Changes
    metrics: Metrics
    limits: Limits
    reads: WorkQueue
    """Calls that read, or compute quickly, and write nothing."""
    writes: WorkQueue
    """Calls that may wait for a lock of the database, scans above all: apart, so that no read waits for one."""
    probes: WorkQueue
    """Whether the service is ready."""
    feeds: Feeds
    """Who follows sessions; their reads have a line of their own."""
    reader: Reader
    """Reads messages from bytes."""
    names: frozenset[str] | None
    """Names under which the service may be called, besides loopback's; None: any."""
    heavy: WorkQueue
    """Rankings, predictions, scenarios."""
    meshes: WorkQueue
    """Mesh files: only so many at a time as there is memory for."""
    rests: WorkQueue
    """Stable poses of objects: apart, so that no ranking waits for one."""
