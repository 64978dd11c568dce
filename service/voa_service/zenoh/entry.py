"""Service on Zenoh, beside HTTP in the same process: builds and starts its parts."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
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


@contextmanager
def on_zenoh(services: Services, settings: ZenohSettings, robots: Path | None = None) -> Iterator[None]:
    """Serve on Zenoh within a `with` block, as soon as a router answers; does nothing where no router is configured.

    The block begins once the service receives every message, unless no router answers: a replica that reports that it
    is ready, so that another may leave, must not miss what robots publish meanwhile.

    Args:
        services: use cases and queues.
        settings: router, credentials and key prefix.
        robots: file that maps the ROS 2 topics of robots to sessions; None: no mapping.
    """
    if not settings.connect:
        yield
        return
    keys = Keys(settings.root)
    link = services.health.link
    replicas = Replicas(services.health.replica, keys)
    outbox = Outbox(services.sessions.message, keys, link, services.metrics)
    queries = Queries(Rpc(services), keys, services.metrics, services.limits.body_bytes)
    with ExitStack() as stack:
        scans = Scans(services, keys, replicas, outbox, settings.grace_seconds)
        stack.callback(scans.close)
        stack.enter_context(services.changes.listening(outbox.committed))
        parts: list[Part] = [outbox.on, replicas.on, scans.on, queries.on]
        if robots is not None:
            tools = RosTools(services, keys, replicas, outbox, settings.grace_seconds)
            ros2 = Ros2(services, robots, replicas, outbox, settings.grace_seconds, tools.on)
            stack.callback(ros2.close)
            parts.append(ros2.on)
        own = ZenohLink(settings, link, services.metrics, parts)
        stack.callback(own.close)
        own.wait_for_first_try(_JOIN_SECONDS)
        yield
