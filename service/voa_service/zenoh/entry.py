"""Service on Zenoh, beside HTTP in the same process: builds and starts its parts."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

from voa_msgs.keys import Keys
from voa_service.ros_tools.entry import RosTools
from voa_service.rpc.entry import Rpc
from voa_service.services import Services
from voa_service.settings import ZenohSettings
from voa_service.zenoh.link import Part, ZenohLink
from voa_service.zenoh.outbox import Outbox
from voa_service.zenoh.queries import Queries
from voa_service.zenoh.replicas import Replicas
from voa_service.zenoh.ros2 import Ros2
from voa_service.zenoh.scans import Scans

_JOIN_SECONDS = 3.0
"""Longest time that a start waits for a router that neither answers nor refuses."""
_LEFT_SECONDS = 5.0
"""Time until the end of a process that does not state it."""
_LEAVE_SECONDS, _CLOSE_SECONDS = 1.0, 1.0
"""Parts of the time left that are kept for what ends after the last scan: the link, then the database."""


@contextmanager
def on_zenoh(
    services: Services,
    settings: ZenohSettings,
    robots: Path | None = None,
    left: Callable[[], float] = lambda: _LEFT_SECONDS,
) -> Iterator[None]:
    """Serve on Zenoh within a `with` block, as soon as a router answers; does nothing where no router is configured.

    The block begins once the service receives every message, unless no router answers: a replica that reports that it
    is ready, so that another may leave, must not miss what robots publish meanwhile. At the end the service leaves its
    scans and robots to the other replicas first, then applies what it has received, as long as there is time left.

    Args:
        services: use cases and queues.
        settings: router, credentials and key prefix.
        robots: file that maps the ROS 2 topics of robots to sessions; None: no mapping.
        left: returns the seconds until the process is ended.
    """
    if not settings.connect:
        yield
        return
    keys = Keys(settings.root)
    link = services.health.link
    replicas = Replicas(services.health.replica, keys)
    outbox = Outbox(services.sessions.message, keys, link, services.metrics)
    until_closing = partial(_before, _CLOSE_SECONDS, left)
    until_leaving = partial(_before, _LEAVE_SECONDS, until_closing)
    queries = Queries(Rpc(services), keys, services.metrics, services.limits.body_bytes)
    with ExitStack() as stack:
        scans = Scans(services, keys, replicas, outbox, settings.grace_seconds, until_leaving)
        stack.callback(scans.close)
        stack.enter_context(services.changes.listening(outbox.committed))
        finishing: list[Part] = [scans.finishing]
        receiving: list[Part] = [scans.on, queries.on]
        if robots is not None:
            tools = RosTools(services, keys, replicas, outbox, settings.grace_seconds, until_leaving)
            ros2 = Ros2(services, robots, replicas, outbox, settings.grace_seconds, until_leaving, tools.on)
            stack.callback(tools.close)
            stack.callback(ros2.close)
            finishing += [tools.finishing, ros2.finishing]
            receiving.append(ros2.on)
        parts = [outbox.on, *finishing, replicas.on, *receiving]
        own = ZenohLink(settings, link, services.metrics, parts, until_closing)
        stack.callback(own.close)
        own.wait_for_first_try(_JOIN_SECONDS)
        yield


def _before(kept_s: float, left: Callable[[], float]) -> float:
    return max(0.0, left() - kept_s)
